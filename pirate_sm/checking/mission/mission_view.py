"""A mission as seen by the rules: its content, places in its files, and what can happen."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import TypeVar

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration import Exploration, Explored, story
from pirate_sm.checking.exploring.signal_ranges import Range
from pirate_sm.checking.findings import Finding, Severity, usual_severity
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Wait

_LONGEST_STEP = 10
"""Pattern for the line of a step that names the command."""


class MissionPlaces:
    """Finds places in a mission's files.

    Args:
        loaded: The mission; its own file is the first of its documents.
    """

    def __init__(self, loaded: LoadedMission) -> None:
        self._own = loaded.documents[0]
        self._aliases = loaded.loaded_robot.profile.aliases
        self._documents = {document.name: document for document in loaded.documents}

    def written(self, text: str, command: str) -> str:
        """Return a command's name as written in the step at ``file:line:col``."""
        others = [alias for alias, name in self._aliases.items() if name == command]
        place = self.read(text)
        if not others or place.file not in self._documents:
            return command
        lines = self._documents[place.file].lines[place.line - 1 : place.line + _LONGEST_STEP]
        names = "|".join([command, *others])
        word = re.search(rf"\b(?:{names})\b", "\n".join(lines)[place.column - 1 :])
        return command if word is None or word[0] == command else f"{word[0]} ({command})"

    def read(self, text: str) -> Place:
        """Return the place of ``file:line:col``."""
        return Place.read(text)

    def of(self, path: Path, *, key: bool = False) -> Place:
        """Return the place of a part of the mission's own file."""
        return self._own.place_of(path, key=key)

    def mission(self) -> Place:
        """Return the place of the mission's name."""
        return self.of(("mission",))

    def finding(
        self,
        place: Place,
        code: str,
        message: str,
        *,
        severity: Severity | None = None,
        fix: str = "",
        happens: tuple[Exploration, int] | None = None,
        playable: bool = True,
    ) -> Finding:
        """Return a finding at a place, with its source line.

        Args:
            place: The place.
            code: An entry of the catalogue.
            message: What is wrong.
            severity: The severity; None for the usual one of the code.
            fix: How to fix it.
            related: Related places, each with an explanation.
            happens: The step of an exploration in which it happens, for its story.
            playable: Whether a trace of the unchanged mission can reach that step.
        """
        document = self._documents.get(place.file)
        excerpt = document.excerpt(place.line) if document else ""
        severity = usual_severity(code) if severity is None else severity
        told = story(*happens, self.written) if happens else ()
        found = happens is not None and happens[0].is_playable(happens[1])
        sure = playable and found and severity is not Severity.POSSIBLE
        return Finding(
            code,
            severity,
            place,
            message,
            fix=fix,
            excerpt=excerpt,
            story=told,
            course=(happens,) if happens and sure else (),
        )


@dataclass(frozen=True)
class MissionView:
    """A mission that is being checked.

    Attributes:
        loaded: The mission.
        places: The places of its parts.
        conditions: Decides which conditions can be true together.
        explored: Explorations: of the mission as it is, then without steps that can never run.
        seen: These, and explorations with other faults corrected.
        in_pipe: The course of the mission in its pipe; None without one.
    """

    loaded: LoadedMission
    places: MissionPlaces
    conditions: Conditions
    explored: Sequence[Explored]
    seen: Sequence[Explored]
    in_pipe: PipeView | None = None

    @property
    def complete(self) -> bool:
        """Return whether the exploration was complete."""
        return all(each.found.complete for each in self.seen)


# --- how far and fast it drives ------------------------------------------------------------------


T = TypeVar("T")


def within_reach(view: MissionView) -> Conditions:
    """Return the conditions for a robot limited by the no-load speed of its motors."""
    robot, most = view.loaded.robot, fastest_m_s(view.loaded)
    if robot.speed < 0:
        return view.conditions
    return view.conditions.within({robot.vocabulary.numbers[robot.speed]: Range(-most, most)})


def fastest_m_s(loaded: LoadedMission) -> float:
    """Return the no-load speed of the fastest wheel, m/s; infinite if unknown."""
    profile = loaded.loaded_robot.profile
    rates = [
        profile.motors[slot.motor].no_load_speed
        for board in profile.boards
        for slot in board.slots
        if slot.wheel is not None
    ]
    known = [each for each in rates if each is not None]
    return max(known) * profile.body.wheel_radius if known and len(known) == len(rates) else inf


def driven_before(
    found: Exploration, driven: Sequence[Collection[int]]
) -> Iterator[tuple[int, str]]:
    """Yield each node after a wait in which the robot has driven, with the place of the wait.

    Args:
        found: The exploration.
        driven: Per configuration the regions that drive wheels.
    """
    for step in found.steps:
        if step.source < 0:
            continue
        before = found.nodes[step.source].state
        it = found.program.instructions[before.mission.pc]
        left = found.nodes[step.target].state.mission.pc != before.mission.pc
        drives = before.mission.begun and driven[before.robot.configuration]
        if isinstance(it, Wait) and left and drives:
            yield step.target, it.place


def led_to(found: Exploration, begun: Iterable[tuple[int, T]]) -> Mapping[str, set[T]]:
    """Return for each phase what has begun in it, or in nodes that can lead to it.

    Of more than two things at least two are returned: enough to know whether one is not alone.

    Args:
        found: The exploration.
        begun: Nodes, each with what begins there.
    """
    after, known = defaultdict[int, list[int]](list), defaultdict[int, set[T]](set)
    for step in found.steps:
        after[step.source].append(step.target)
    waiting, phases = list(begun), defaultdict[str, set[T]](set)
    while waiting:
        node, what = waiting.pop()
        here = known[node]
        if what not in here and len(here) < 2:
            here.add(what)
            phases[found.program.phase_of[found.nodes[node].state.mission.pc]].add(what)
            waiting += [(each, what) for each in after[node]]
    return phases

"""A mission as seen by the rules: its content, places in its files, and what can happen."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.exploring.story import story
from pirate_sm.checking.findings import Finding, Severity, usual_severity
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.loading import LoadedMission

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

"""What is known of a mission: from its files, and from what the check has last explored."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from math import inf

from pirate_sm.checking.actuation_in_force import InForce
from pirate_sm.checking.exploring.exploration import Explored
from pirate_sm.checking.exploring.signal_ranges import Range, ranges
from pirate_sm.checking.mission.time_and_order import earliest_s, took_s
from pirate_sm.checking.pipe.usual_course import course_of
from pirate_sm.core import program as steps
from pirate_sm.core.documents import FileKind, kind_of_text
from pirate_sm.core.effects import Ended, PhaseChange
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import Mission
from pirate_sm.core.robot import RobotState, refusal

_MARK = "zzqxj"
_COMMAND = re.compile(r"command: *\Z")
_KEY = re.compile(r"^(\w+) *:", re.MULTILINE)


@dataclass(frozen=True)
class KnownMission:
    """A mission as far as it is known.

    Attributes:
        loaded: The mission; targets that it does not have lead nowhere.
        explored: All that can happen to it; empty as long as not all of it was explored.
    """

    loaded: LoadedMission
    explored: tuple[Explored, ...] = ()

    @classmethod
    def checked(cls, loaded: LoadedMission, explored: tuple[Explored, ...]) -> KnownMission:
        """Return a mission with what the check explored; without it if that reached its limits."""
        whole = all(book.found.complete for book in explored)
        return cls(loaded, explored if whole else ())

    @property
    def text(self) -> str:
        """Return the text that is known."""
        return self.loaded.documents[0].text

    @cached_property
    def ranges(self) -> Mapping[str, Range]:
        """Return the range of each signal."""
        return ranges(self.loaded.loaded_robot.profile, self.loaded.robot)

    # --- phases and ends ---

    def states_in(self, phase: str) -> Mapping[str, list[str]]:
        """Return the states that can hold in a phase, by region; none where all can."""
        table = self.loaded.robot.table
        seen = {
            table.configurations[node.state.robot.configuration]
            for book in self.explored
            for node in book.found.nodes
            if _is_in(phase, book.found.program, node.state.mission.pc)
        }
        found = {
            region: [name for name in names if any(each[place] == name for each in seen)]
            for place, (region, names) in enumerate(zip(table.regions, table.states, strict=True))
        }
        whole = dict(zip(table.regions, table.states, strict=True))
        return {n: names for n, names in found.items() if 0 < len(names) < len(whole[n])}

    def times_s(self, name: str) -> tuple[float, float]:
        """Return the shortest and the longest time to a phase or an end, s.

        The shortest is with the nominal durations of commands: infinite if nothing leads there,
        and 0 as long as not all was explored. The longest is that of all limits, and infinite if
        nothing limits it.
        """
        unseen_s = inf if self.explored else 0.0
        return self._shortest_s.get(name, unseen_s), self._longest_s.get(name, inf)

    @cached_property
    def _shortest_s(self) -> Mapping[str, float]:
        """Return the shortest time to each phase and end, also where nothing waits in it, s."""
        found = defaultdict[str, float](lambda: inf)
        for book in self.explored:
            earliest = earliest_s(book.found)
            for step in book.found.steps:
                time_s = earliest.get(step.source, 0.0) + took_s(book.found, step)
                names = [each.phase for each in step.effects if isinstance(each, PhaseChange)]
                names += [each.end for each in step.effects if isinstance(each, Ended)]
                ending = book.found.nodes[step.target].state.mission.ending
                names += [ending.end] if ending else []
                found |= {each: min(found[each], time_s) for each in names}
        return found

    @cached_property
    def _longest_s(self) -> Mapping[str, float]:
        program, before = self.loaded.program, defaultdict[int, set[int]](set)
        for at in program.reached() if program.start >= 0 else ():
            for target in program.successors(at):
                before[target].add(at)
        found: dict[str, float] = {}
        for at, it in enumerate(program.instructions):
            match it:
                case steps.Enter(phase=name) | steps.Finish(end=name) if at in before:
                    found[name] = min(self._longest_to_s(at, before), program.time_limit_s)
                case _ if at == program.start:
                    found[program.phase_of[at]] = 0.0
        return found

    def _longest_to_s(self, target: int, before: Mapping[int, set[int]]) -> float:
        """Return the longest time until an instruction is first reached, s."""
        ways, waiting = dict[int, set[int]](), [target]
        while waiting:
            at = waiting.pop()
            if at not in ways:
                ways[at] = before.get(at, set()) - {target}
                waiting += ways[at]
        times_s: dict[int, float] = {}
        try:
            for at in TopologicalSorter(ways).static_order():
                times_s[at] = max(
                    (times_s[each] + self._most_s(each) for each in ways[at]), default=0
                )
        except CycleError:
            return inf
        return times_s[target]

    def _most_s(self, at: int) -> float:
        """Return how long an instruction may take, s."""
        match self.loaded.program.instructions[at]:
            case steps.Do() as it:
                usual_s = self.loaded.robot.commands[it.command].timeout_s
                return (it.timeout_s or usual_s) * (1 + it.retries)
            case steps.Wait() as it:
                return min(
                    [it.within_s, *(t.after_s for t in it.triggers if t.after_s is not None)]
                )
            case steps.SwitchControl(timeout_s=most_s) | steps.Question(timeout_s=most_s):
                return most_s
            case _:
                return 0.0

    # --- commands ---

    def refusals(self, command: int) -> tuple[int, set[str]]:
        """Return in how many states at the mark a command is taken, and why not in the others."""
        robot, taken, why = self.loaded.robot, 0, set[str]()
        for configuration in self.at_mark:
            refused = refusal(robot, RobotState(configuration, ()), command)
            taken += not refused
            why |= {str(refused)} if refused else set()
        return taken, why

    @cached_property
    def at_mark(self) -> frozenset[int]:
        """Return the configurations at the mark in the text: those of the course to it."""
        said = enumerate(self.loaded.program.instructions)
        marks = {at for at, it in said if isinstance(it, steps.Say) and it.message == _MARK}
        force = InForce(self.loaded.loaded_robot.profile, self.loaded.robot)
        course = course_of(force, self.loaded.program, failing=True) if marks else None
        situations = course.situations if course else ()
        return frozenset(each.configuration for each in situations if each.at in marks)


def _is_in(phase: str, program: steps.Program, at: int) -> bool:
    """Return whether an instruction belongs to a phase, also by a call."""
    home = program.phase_of[at] if 0 <= at < len(program.phase_of) else ""
    return home == phase or home.startswith(f"{phase}/")


def marked(text: str, start: int, end: int) -> Iterator[str]:
    """Yield texts with a mark for a word: as a step, whose states `at_mark` has, a value, a key."""
    before, key = text[:start], _COMMAND.search(text[:start])
    if key is not None:
        yield f"{before[: key.start()]}log: {_MARK}{text[end:]}"
    else:
        yield f"{before}{{log: {_MARK}}}{text[end:]}"
    yield from (f"{before}{_MARK}{ends}{text[end:]}" for ends in ("", ": x"))


def may_be_mission(text: str) -> bool:
    """Return whether a text is a mission, or can become one: it has no keys but those of one."""
    kind, keys = kind_of_text(text), _KEY.findall(text)
    return kind is FileKind.MISSION or (
        kind is FileKind.OTHER and {*keys} <= {*Mission.model_fields}
    )

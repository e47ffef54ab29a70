"""Check a valid chart: run the rules about transitions, guards, traps and idle commands.

Findings are:

- A guard, or a part of it, that has the same value in every *thinkable* combination of states. A
  whole guard that is constant whenever its own state is active. A part that is constant only
  because of its own state, or because commands reach no other combination, is a redundancy that
  careful authors use, and not a finding.
- A transition that is never taken in a *reached* combination, unless its guard is reported already.
- Two transitions of a state on the same event that can both be taken and lead to different states:
  the library takes the first one without a warning.
- A state that no transition leaves (a trap), and a combination of states in which every command is
  refused.

The loader reports states that no commands reach (`chart.unreachable`), events without a command
(`robot.command`) and commands without an event (`robot.name`).
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import (
    ChartView,
    constant,
    constant_parts,
    offset_of,
    regions_of,
)
from pirate_sm.core.documents import Document, Path, Place, Problems
from pirate_sm.core.loading import (
    ChartOutline,
    ChartTransition,
    LoadedRobot,
    conjuncts,
    holds,
    outline_chart,
)
from pirate_sm.core.robot import ChartTable

# --- transitions ---------------------------------------------------------------------------------


class _Verdict(NamedTuple):
    """The verdict on a transition in one of the states to which it applies.

    Attributes:
        silent: Whether it is never taken in this state, although the state is reached.
    """

    transition: ChartTransition
    finding: Finding | None
    reached: bool
    silent: bool


def _rivals(outline: ChartOutline) -> Iterator[list[ChartTransition]]:
    """Yield the transitions of each state and event, in the order of precedence."""

    def key(each: ChartTransition) -> tuple[str, str]:
        return each.source, each.event

    for _, group in groupby(sorted(outline.transitions, key=key), key):
        yield list(group)


class TransitionRules:
    """The rules about the transitions of one chart.

    Attributes:
        found: The findings, by the path of the transition.
        silent: Transitions that are never taken.
    """

    def __init__(self, chart: ChartView) -> None:
        self._chart = chart
        self.found: dict[Path, Finding] = {}
        self.silent: list[ChartTransition] = []
        verdicts: dict[tuple[Path, str], list[_Verdict]] = {}
        for group in _rivals(chart.outline):
            for number, transition in enumerate(group):
                verdict = self._judge(transition, group[:number])
                verdicts.setdefault((transition.path, transition.event), []).append(verdict)
        for alike in verdicts.values():
            self._settle(alike)

    def _judge(self, transition: ChartTransition, earlier: Sequence[ChartTransition]) -> _Verdict:
        """Return the verdict on a transition in one state.

        Args:
            transition: The transition.
            earlier: The transitions of the same state and event that precede it.
        """
        finding = self._guard(transition) if transition.tree else None
        reached, silent = self._is_reached(transition), False
        if not self._chances(transition):
            finding = finding or self._never(transition)
            silent = reached
        rivalry, hidden = self._rivalry(transition, earlier)
        return _Verdict(transition, finding or rivalry, reached, silent or hidden)

    def _settle(self, verdicts: Sequence[_Verdict]) -> None:
        """Record findings that apply in every state of a transition."""
        seen = [each for each in verdicts if each.reached] or verdicts
        if all(each.finding for each in seen):
            finding = seen[0].finding
            assert finding is not None
            self.found.setdefault(seen[0].transition.path, finding)
        if all(each.silent for each in seen):
            self.silent += [each.transition for each in seen]

    def _guard(self, transition: ChartTransition) -> Finding | None:
        """Return a finding about a guard, or a part of it, that is constant in every state."""
        guard = transition.tree
        assert guard is not None
        for part, value in constant_parts(guard, self._chart.states):
            what = "this guard" if part is guard else "this part of the guard"
            return self._constant(transition, part, value, f"{what} is always {_said(value)}")
        own = {transition.region: transition.source.partition(".")[2]}
        alone = constant(guard, self._chart.states, own)
        if alone is None:
            return None
        message = f"this guard is always {_said(alone)} in {transition.source}, where it is asked"
        return self._constant(transition, guard, alone, message)

    def _constant(
        self, transition: ChartTransition, part: ast.expr, value: bool, message: str
    ) -> Finding:
        code = "chart.guard_always" if value else "chart.guard_never"
        return self._chart.at(self._place(transition, part), code, message)

    def _never(self, transition: ChartTransition) -> Finding | None:
        """Return a finding about a transition whose guard is false in all reached states."""
        if not self._is_reached(transition) or transition.tree is None:
            return None  # reported for its state
        blocking = next(
            (part for part in conjuncts(transition.tree) if not self._chances(transition, part)),
            transition.tree,
        )
        message = (
            f"{transition.event} never leads from {transition.source} to {transition.target}:"
            " this is false in every combination that commands lead to"
        )
        return self._chart.at(self._place(transition, blocking), "chart.transition_never", message)

    def _rivalry(
        self, transition: ChartTransition, earlier: Sequence[ChartTransition]
    ) -> tuple[Finding | None, bool]:
        """Return a finding if another transition of its event precedes it, and whether always.

        A transition inside a compound state intentionally precedes one of the compound state.
        """
        regions = frozenset({transition.region}).union(
            *(regions_of(each.tree) for each in (transition, *earlier) if each.tree)
        )
        first: ChartTransition | None = None
        shadowed = True
        winner: ChartTransition | None = None
        for states in self._chart.reached.through(regions):
            if not _can(transition, states):
                continue
            ahead = next((each for each in earlier if _can(each, states)), None)
            shadowed = shadowed and ahead is not None
            first = first or ahead
            rivals = ahead is not None and ahead.owner == transition.owner
            if ahead is not None and rivals and ahead.target != transition.target:
                winner = winner or ahead
        if winner is not None:
            return self._ambiguous(transition, winner, shadowed), shadowed
        if first is None or not shadowed:
            return None, False
        place = self._chart.document.place_of(first.path)
        message = (
            f"this is never taken: line {place.line} leads from {transition.source} to"
            f" {first.target} already"
        )
        finding = self._chart.at(
            self._chart.document.place_of((*transition.path, "event")),
            "chart.transition_never",
            message,
            related=((place, "this is taken"),),
        )
        return finding, True

    def _ambiguous(
        self, transition: ChartTransition, winner: ChartTransition, always: bool
    ) -> Finding:
        place = self._chart.document.place_of((*winner.path, "event"))
        when = "always" if always else "also"
        message = (
            f"where {transition.event} can lead from {transition.source} to {transition.target},"
            f" it can {when} lead to {winner.target}, which is taken because it comes first"
        )
        return self._chart.at(
            self._chart.document.place_of((*transition.path, "event")),
            "chart.ambiguous",
            message,
            related=((place, "this is taken"),),
        )

    def _chances(self, transition: ChartTransition, part: ast.expr | None = None) -> bool:
        """Return whether its state and (a part of) its guard are true in a reached combination."""
        node = transition.tree if part is None else part
        if node is None:
            return self._is_reached(transition)
        seen = self._chart.reached.through(regions_of(node) | {transition.region})
        return any(_is_in(transition, states) and holds(node, states) for states in seen)

    def _is_reached(self, transition: ChartTransition) -> bool:
        seen = self._chart.reached.through(frozenset({transition.region}))
        return any(_is_in(transition, states) for states in seen)

    def _place(self, transition: ChartTransition, part: ast.expr) -> Place:
        """Return the place of a part of a transition's guard."""
        path = (*transition.path, "cond")
        offset = offset_of(transition.guard, part)
        written = self._chart.document.data
        for key in path:
            written = written[key]
        offset += len(written) - len(written.lstrip())
        return self._chart.document.place_of(path, offset=offset)


def _is_in(transition: ChartTransition, states: dict[str, str]) -> bool:
    return f"{transition.region}.{states[transition.region]}" == transition.source


def _can(transition: ChartTransition, states: dict[str, str]) -> bool:
    if not _is_in(transition, states):
        return False
    return transition.tree is None or holds(transition.tree, states)


def _said(value: bool) -> str:
    return "true" if value else "false"


# --- dead ends -----------------------------------------------------------------------------------


def traps(chart: ChartView, silent: Iterable[ChartTransition]) -> Iterator[Finding]:
    """Yield states that no transition leaves, and combinations in which all commands are refused.

    Args:
        chart: The chart.
        silent: Transitions that are never taken; their consequences are not reported as traps.
    """
    left = {each.source for each in chart.outline.transitions if each.source != each.target}
    reached = [set(names) for names in zip(*chart.table.configurations, strict=True)]
    trapped = set()
    for (region, states), seen in zip(chart.states.items(), reached, strict=True):
        for state in states if len(states) > 1 else ():
            if f"{region}.{state}" not in left and state in seen:
                trapped.add(f"{region}.{state}")
                place = chart.document.place_of(chart.outline.place_of(region, state), key=True)
                yield chart.at(place, "chart.trap", f"no transition leads out of {region}.{state}")
    excused = trapped | {each.source for each in silent}
    stuck = _stuck(chart, excused)
    if stuck:
        yield _dead_end(chart, stuck)


def idle_commands(chart: ChartView, known: Collection[Path]) -> Iterator[Finding]:
    """Yield commands that are accepted but never change a state.

    Args:
        chart: The chart.
        known: Paths of transitions that have a finding already.
    """
    for number, command in enumerate(chart.table.commands):
        moves = [each for each in chart.outline.transitions if each.event == command]
        if any(each.path in known for each in moves):
            continue
        if all(row[number] == index for index, row in enumerate(chart.table.following)):
            message = f"'{command}' changes nothing anywhere: it leads each state back to itself"
            yield chart.at(
                chart.document.place_of((*moves[0].path, "event")), "chart.command_idle", message
            )


def _stuck(chart: ChartView, excused: set[str]) -> list[int]:
    """Return reached combinations in which every command is refused, without excused states."""
    return [
        index
        for index, row in enumerate(chart.table.following)
        if index != chart.table.initial
        and all(each == index for each in row)
        and not any(
            f"{region}.{state}" in excused
            for region, state in zip(
                chart.table.regions, chart.table.configurations[index], strict=True
            )
        )
    ]


def _dead_end(chart: ChartView, stuck: Sequence[int]) -> Finding:
    """Return one finding for all dead ends, at a transition into the first one."""
    index = stuck[0]
    before, command = next(
        (number, command)
        for number, row in enumerate(chart.table.following)
        for command, after in enumerate(row)
        if after == index and number != index
    )
    after = chart.table.configurations[index]
    place = next(
        number
        for number, state in enumerate(after)
        if state != chart.table.configurations[before][number]
    )
    region, state = chart.table.regions[place], after[place]
    source = f"{region}.{chart.table.configurations[before][place]}"
    leading = next(
        each
        for each in chart.outline.transitions
        if (each.source, each.event) == (source, chart.table.commands[command])
        and each.target == f"{region}.{state}"
    )
    others = [
        f"{name}.{each}"
        for name, each in zip(chart.table.regions, after, strict=True)
        if name != region
    ]
    more = f" ({len(stuck)} such combinations)" if len(stuck) > 1 else ""
    beside = f" with {', '.join(others)}" if others else ""
    message = f"every command is refused in {region}.{state}{beside}{more}"
    return chart.at(chart.document.place_of((*leading.path, "target")), "chart.trap", message)


# --- the check -----------------------------------------------------------------------------------


class ChartCheck(NamedTuple):
    """The result of checking a chart.

    Attributes:
        findings: The findings, ordered by place.
        silent: Transitions that are never taken; each has a finding.
    """

    findings: tuple[Finding, ...]
    silent: tuple[ChartTransition, ...]


def check_chart(loaded: LoadedRobot) -> tuple[Finding, ...]:
    """Return the findings about a robot's chart, ordered by place."""
    document = loaded.documents[1]
    outline = outline_chart(document, Problems(document))
    assert outline is not None  # the robot has been loaded
    return examine(document, outline, loaded.table).findings


def examine(document: Document, outline: ChartOutline, table: ChartTable) -> ChartCheck:
    """Return the result of checking a chart.

    Args:
        document: Its file.
        outline: The declarations of the file.
        table: The table of its configurations.
    """
    chart = ChartView(document, outline, table)
    rules = TransitionRules(chart)
    found = [*rules.found.values(), *traps(chart, rules.silent), *idle_commands(chart, rules.found)]
    return ChartCheck(tuple(sorted(found, key=lambda each: each.order)), tuple(rules.silent))


def cut_off(outline: ChartOutline, silent: Sequence[ChartTransition]) -> frozenset[tuple[str, str]]:
    """Return the states, by region, that are unreachable because of transitions never taken.

    It applies only to states that are not reached, because it follows transitions without guards.
    """
    found = {(each.region, each.target.partition(".")[2]) for each in silent}
    while True:
        beyond = {
            (each.region, each.target.partition(".")[2])
            for each in outline.transitions
            if (each.region, each.source.partition(".")[2]) in found
        }
        if beyond <= found:
            return frozenset(found)
        found |= beyond

"""What is wrong with a chart that loads: transitions, guards and commands without effect.

What is a finding, and what is not:

- A guard, or a part of it, that is the same in every *thinkable* combination of states says
  nothing; so does a whole guard that is the same whenever its own state is active. A part that is
  only constant because of its own state, or because commands lead to no other combination, is
  what a careful author writes twice, and no finding.
- A transition that is never taken in a *reached* combination is one, unless its guard has been
  named already.
- Two transitions of a state that can be taken at the same event are one where they lead to
  different states: the library takes the first of them without a word.
- A state that no transition leaves is a trap, and so is a combination of states in which every
  command is refused.

A state that no commands lead to is found at loading (`chart.unreachable`), and so are events
without a command (`robot.command`) and commands without an event (`robot.name`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.guards import (
    Reached,
    conjuncts,
    constant,
    constant_parts,
    holds,
    offset_of,
    regions_of,
)
from pirate_sm.loading.chart.outline import ChartOutline, Transition
from pirate_sm.loading.chart.outline_reader import outline_chart
from pirate_sm.loading.problems import Path, Place, Problems

if TYPE_CHECKING:
    import ast

    from pirate_sm.engine.robot.chart_table import ChartTable
    from pirate_sm.loading.robot import LoadedRobot
    from pirate_sm.loading.yaml.document import Document


class ChartCheck(NamedTuple):
    """What is wrong with a chart.

    Attributes:
        findings: By place.
        silent: Transitions that are never taken, each named by a finding.
    """

    findings: tuple[Finding, ...]
    silent: tuple[Transition, ...]


def check_chart(loaded: LoadedRobot) -> tuple[Finding, ...]:
    """What is wrong with a robot's chart, by place."""
    document = loaded.documents[1]
    outline = outline_chart(document, Problems(document))
    assert outline is not None  # the robot has been loaded
    return examine(document, outline, loaded.table).findings


def examine(document: Document, outline: ChartOutline, table: ChartTable) -> ChartCheck:
    """What is wrong with a chart.

    Args:
        document: Its file.
        outline: What the file declares.
        table: What follows from that.
    """
    chart = _Chart(document, outline, table)
    verdicts: dict[tuple[Path, str], list[_Verdict]] = {}
    for group in _rivals(outline):
        for number, transition in enumerate(group):
            verdict = chart.judge(transition, group[:number])
            verdicts.setdefault((transition.path, transition.event), []).append(verdict)
    for alike in verdicts.values():
        chart.settle(alike)
    findings = [*chart.found.values(), *chart.traps(), *chart.idle()]
    return ChartCheck(tuple(sorted(findings, key=lambda each: each.order)), tuple(chart.silent))


def cut_off(outline: ChartOutline, silent: Sequence[Transition]) -> frozenset[tuple[str, str]]:
    """States, by region, that no commands lead to because these transitions are never taken.

    Only of use for states that are not reached: it follows transitions wherever they lead.
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


class _Verdict(NamedTuple):
    """What is to be said of a transition in one of the states in which it counts.

    Attributes:
        silent: Whether it is never taken there, although the state is reached.
    """

    transition: Transition
    finding: Finding | None
    reached: bool
    silent: bool


def _rivals(outline: ChartOutline) -> Iterator[list[Transition]]:
    """The transitions of one state at one event, the first that counts first."""

    def key(each: Transition) -> tuple[str, str]:
        return each.source, each.event

    for _, group in groupby(sorted(outline.transitions, key=key), key):
        yield list(group)


@dataclass
class _Chart:
    """A chart under examination.

    Attributes:
        found: What was found, by the path of the transition.
        silent: Transitions that are never taken.
    """

    document: Document
    outline: ChartOutline
    table: ChartTable
    found: dict[Path, Finding] = field(default_factory=dict)
    silent: list[Transition] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._reached = Reached(self.table)
        self._states = dict(zip(self.outline.regions, self.outline.states, strict=True))

    def judge(self, transition: Transition, earlier: Sequence[Transition]) -> _Verdict:
        """The worst that can be said of a transition in one state.

        Args:
            transition: The transition.
            earlier: Those of the same state and event that come before it.
        """
        finding = self._guard(transition) if transition.tree else None
        reached, silent = self._is_reached(transition), False
        if not self._chances(transition):
            finding = finding or self._never(transition)
            silent = reached
        rivalry, hidden = self._rivalry(transition, earlier)
        return _Verdict(transition, finding or rivalry, reached, silent or hidden)

    def settle(self, verdicts: Sequence[_Verdict]) -> None:
        """What is so in every state in which a transition counts has been noted of it."""
        seen = [each for each in verdicts if each.reached] or verdicts
        if all(each.finding for each in seen):
            finding = seen[0].finding
            assert finding is not None
            self.found.setdefault(seen[0].transition.path, finding)
        if all(each.silent for each in seen):
            self.silent += [each.transition for each in seen]

    def traps(self) -> Iterator[Finding]:
        """States that no transition leaves, and combinations in which nothing can be done."""
        left = {each.source for each in self.outline.transitions if each.source != each.target}
        reached = [set(names) for names in zip(*self.table.configurations, strict=True)]
        trapped = set()
        for (region, states), seen in zip(self._states.items(), reached, strict=True):
            for state in states if len(states) > 1 else ():
                if f"{region}.{state}" not in left and state in seen:
                    trapped.add(f"{region}.{state}")
                    place = self.document.place_of(self.outline.place_of(region, state), key=True)
                    yield self._at(
                        place, "chart.trap", f"no transition leads out of {region}.{state}"
                    )
        excused = trapped | {each.source for each in self.silent}
        stuck = self._stuck(excused)
        if stuck:
            yield self._dead_end(stuck)

    def idle(self) -> Iterator[Finding]:
        """Commands that are taken and change nothing anywhere."""
        for number, command in enumerate(self.table.commands):
            moves = [each for each in self.outline.transitions if each.event == command]
            if any(each.path in self.found for each in moves):
                continue
            if all(row[number] == index for index, row in enumerate(self.table.following)):
                yield self._at(
                    self.document.place_of((*moves[0].path, "event")), "chart.command_idle",
                    f"'{command}' changes nothing anywhere: it leads each state back to itself",
                )  # fmt: skip

    # --- guards and rivals --------------------------------------------------------------------

    def _guard(self, transition: Transition) -> Finding | None:
        """A guard, or a part of one, that is the same whatever states are thought of."""
        guard = transition.tree
        assert guard is not None
        for part, value in constant_parts(guard, self._states):
            what = "this guard" if part is guard else "this part of the guard"
            return self._constant(transition, part, value, f"{what} is always {_said(value)}")
        own = {transition.region: transition.source.partition(".")[2]}
        alone = constant(guard, self._states, own)
        if alone is None:
            return None
        message = f"this guard is always {_said(alone)} in {transition.source}, where it is asked"
        return self._constant(transition, guard, alone, message)

    def _constant(
        self, transition: Transition, part: ast.expr, value: bool, message: str
    ) -> Finding:
        code = "chart.guard_always" if value else "chart.guard_never"
        return self._at(self._place(transition, part), code, message)

    def _never(self, transition: Transition) -> Finding | None:
        """A transition whose guard is false wherever the robot can be."""
        if not self._is_reached(transition) or transition.tree is None:
            return None  # that is a finding of its state
        blocking = next(
            (part for part in conjuncts(transition.tree) if not self._chances(transition, part)),
            transition.tree,
        )
        return self._at(
            self._place(transition, blocking), "chart.transition_never",
            f"{transition.event} never leads from {transition.source} to {transition.target}:"
            " this is false in every combination that commands lead to",
        )  # fmt: skip

    def _rivalry(
        self, transition: Transition, earlier: Sequence[Transition]
    ) -> tuple[Finding | None, bool]:
        """What is to be said where another one of its event is taken, and whether it always is.

        One that is written inside a compound state is meant to come before one of that state.
        """
        regions = frozenset({transition.region}).union(
            *(regions_of(each.tree) for each in (transition, *earlier) if each.tree)
        )
        first: Transition | None = None
        shadowed = True
        winner: Transition | None = None
        for states in self._reached.through(regions):
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
        place = self.document.place_of(first.path)
        finding = self._at(
            self.document.place_of((*transition.path, "event")), "chart.transition_never",
            f"this is never taken: line {place.line} leads from {transition.source} to"
            f" {first.target} already",
            related=((place, "this is taken"),),
        )  # fmt: skip
        return finding, True

    def _ambiguous(self, transition: Transition, winner: Transition, always: bool) -> Finding:
        place = self.document.place_of((*winner.path, "event"))
        when = "always" if always else "also"
        return self._at(
            self.document.place_of((*transition.path, "event")), "chart.ambiguous",
            f"where {transition.event} can lead from {transition.source} to {transition.target},"
            f" it can {when} lead to {winner.target}, which is taken because it comes first",
            related=((place, "this is taken"),),
        )  # fmt: skip

    def _chances(self, transition: Transition, part: ast.expr | None = None) -> bool:
        """Whether a reached combination has its state and the guard, or a part of it, true."""
        node = transition.tree if part is None else part
        if node is None:
            return self._is_reached(transition)
        seen = self._reached.through(regions_of(node) | {transition.region})
        return any(_is_in(transition, states) and holds(node, states) for states in seen)

    def _is_reached(self, transition: Transition) -> bool:
        seen = self._reached.through(frozenset({transition.region}))
        return any(_is_in(transition, states) for states in seen)

    # --- dead ends ----------------------------------------------------------------------------

    def _stuck(self, excused: set[str]) -> list[int]:
        """Reached combinations in which every command is refused, of states not named yet."""
        return [
            index
            for index, row in enumerate(self.table.following)
            if index != self.table.initial
            and all(each == index for each in row)
            and not any(
                f"{region}.{state}" in excused
                for region, state in zip(
                    self.table.regions, self.table.configurations[index], strict=True
                )
            )
        ]

    def _dead_end(self, stuck: Sequence[int]) -> Finding:
        """One finding for all dead ends, at a transition that leads into the first one."""
        index = stuck[0]
        before, command = next(
            (number, command)
            for number, row in enumerate(self.table.following)
            for command, after in enumerate(row)
            if after == index and number != index
        )
        after = self.table.configurations[index]
        place = next(
            number
            for number, state in enumerate(after)
            if state != self.table.configurations[before][number]
        )
        region, state = self.table.regions[place], after[place]
        source = f"{region}.{self.table.configurations[before][place]}"
        leading = next(
            each
            for each in self.outline.transitions
            if (each.source, each.event) == (source, self.table.commands[command])
            and each.target == f"{region}.{state}"
        )
        others = [
            f"{name}.{each}"
            for name, each in zip(self.table.regions, after, strict=True)
            if name != region
        ]
        more = f" ({len(stuck)} such combinations)" if len(stuck) > 1 else ""
        beside = f" with {', '.join(others)}" if others else ""
        return self._at(
            self.document.place_of((*leading.path, "target")), "chart.trap",
            f"every command is refused in {region}.{state}{beside}{more}",
        )  # fmt: skip

    # --- places -------------------------------------------------------------------------------

    def _place(self, transition: Transition, part: ast.expr) -> Place:
        """Where a part of a transition's guard stands."""
        path = (*transition.path, "cond")
        offset = offset_of(transition.guard, part)
        written = self.document.data
        for key in path:
            written = written[key]
        offset += len(written) - len(written.lstrip())
        return self.document.place_of(path, offset=offset)

    def _at(
        self, place: Place, code: str, message: str, *, related: Sequence[tuple[Place, str]] = ()
    ) -> Finding:
        mild = code in {"chart.trap", "chart.guard_always"}
        severity = Severity.WARNING if mild else Severity.ERROR
        return at(self.document, place, code, severity, message, related=related)


def _is_in(transition: Transition, states: dict[str, str]) -> bool:
    return f"{transition.region}.{states[transition.region]}" == transition.source


def _can(transition: Transition, states: dict[str, str]) -> bool:
    if not _is_in(transition, states):
        return False
    return transition.tree is None or holds(transition.tree, states)


def _said(value: bool) -> str:
    return "true" if value else "false"

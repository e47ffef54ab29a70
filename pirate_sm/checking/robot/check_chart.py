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

from collections.abc import Sequence
from typing import NamedTuple

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.chart_transitions import TransitionRules
from pirate_sm.checking.robot.chart_view import ChartView
from pirate_sm.checking.robot.dead_ends import idle_commands, traps
from pirate_sm.core.documents import Document, Problems
from pirate_sm.core.loading import ChartOutline, ChartTransition, LoadedRobot, outline_chart
from pirate_sm.core.robot import ChartTable


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

"""Check a chart that loads: run the rules about transitions, guards, traps and idle commands.

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

from collections.abc import Sequence
from typing import NamedTuple

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.chart_transitions import TransitionRules
from pirate_sm.checking.robot.chart_view import ChartView
from pirate_sm.checking.robot.dead_ends import idle_commands, traps
from pirate_sm.engine.robot.chart_table import ChartTable
from pirate_sm.loading.chart.outline import ChartOutline, Transition
from pirate_sm.loading.chart.outline_reader import outline_chart
from pirate_sm.loading.problems import Problems
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
    """Return what is wrong with a robot's chart, by place."""
    document = loaded.documents[1]
    outline = outline_chart(document, Problems(document))
    assert outline is not None  # the robot has been loaded
    return examine(document, outline, loaded.table).findings


def examine(document: Document, outline: ChartOutline, table: ChartTable) -> ChartCheck:
    """Return what is wrong with a chart, by place.

    Args:
        document: Its file.
        outline: What the file declares.
        table: What follows from that.
    """
    chart = ChartView(document, outline, table)
    rules = TransitionRules(chart)
    found = [*rules.found.values(), *traps(chart, rules.silent), *idle_commands(chart, rules.found)]
    return ChartCheck(tuple(sorted(found, key=lambda each: each.order)), tuple(rules.silent))


def cut_off(outline: ChartOutline, silent: Sequence[Transition]) -> frozenset[tuple[str, str]]:
    """Return states, by region, that no commands lead to because these transitions are never taken.

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

"""Rules about charts: states without exit, and commands without effect."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.chart_view import ChartView
from pirate_sm.core.documents import Path
from pirate_sm.core.loading import ChartTransition


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

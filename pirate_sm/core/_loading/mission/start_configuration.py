"""Check that the initial states of a mission exist and that the chart reaches them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading.mission.scope import Source
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import nearest, one_of


def start_configuration(
    source: Source, table: ChartTable, states: Mapping[str, str] | None, problems: Problems
) -> int:
    """Return the index of the mission's initial configuration (rule 2).

    Regions that ``starts_in`` does not name are in their initial state.

    Raises:
        UsageError: ``states``, from the command line, do not fit.
    """
    if states is not None:
        return _declared(table, states)
    about = problems.about(source.document)
    wanted = dict(zip(table.regions, table.configurations[table.initial], strict=True))
    for region, state in (source.mission.starts_in or {}).items():
        if _check(table, region, state, ("starts_in", region), about):
            wanted[region] = state
    index = table.index_of(tuple(wanted.values()))
    if index is None:
        shown = ", ".join(f"{region} {state}" for region, state in wanted.items())
        about.add("mission.start", ("starts_in",), f"no commands lead to {shown}")
        return table.initial
    return index


def required_states(
    source: Source, table: ChartTable, problems: Problems
) -> tuple[tuple[int, str], ...]:
    """Return the states that a called mission requires: its ``starts_in`` or initial states."""
    named = source.mission.starts_in
    if named is None:
        return tuple(enumerate(table.configurations[table.initial]))
    return tuple(
        (table.regions.index(region), state)
        for region, state in named.items()
        if _check(table, region, state, ("starts_in", region), problems)
    )


def _check(table: ChartTable, region: str, state: str, path: Path, problems: Problems) -> bool:
    if region not in table.regions:
        problems.add_unknown("mission.start", path, "region", region, table.regions, key=True)
        return False
    names = table.states[table.regions.index(region)]
    if state not in names:
        problems.add_unknown(
            "mission.start", path, "", state, names, message=f"{region} has no state '{state}'"
        )
        return False
    return True


def read_states(table: ChartTable, states: Mapping[str, str]) -> dict[int, str]:
    """Return states from the command line by the index of their region.

    Raises:
        UsageError: Some are not in the chart; the message lists all, with suggestions.
    """
    found: dict[int, str] = {}
    wrong = []
    for region, state in states.items():
        if region not in table.regions:
            wrong.append(f"there is no region '{region}'{_meant(region, table.regions)}")
            continue
        index = table.regions.index(region)
        if state not in table.states[index]:
            wrong.append(f"{region} has no state '{state}'{_meant(state, table.states[index])}")
        found[index] = state
    if wrong:
        raise UsageError("\n".join(wrong))
    return found


def _meant(word: str, names: Collection[str]) -> str:
    close = nearest(word, names)
    return f"; did you mean '{close}'?" if close else f": {one_of(names)}"


def _declared(table: ChartTable, states: Mapping[str, str]) -> int:
    wanted = list(table.configurations[table.initial])
    for region, state in read_states(table, states).items():
        wanted[region] = state
    index = table.index_of(tuple(wanted))
    if index is None:
        filled = ", ".join(
            f"{region} {state}"
            for region, state in zip(table.regions, wanted, strict=True)
            if region not in states
        )
        message = f"no commands lead to {', '.join(' '.join(each) for each in states.items())}"
        if filled:
            message += f" with {filled}: regions that are not declared are in their initial state"
        raise UsageError(message)
    return index

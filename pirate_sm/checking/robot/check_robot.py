"""Check a robot: load it, and run the rules about its chart and its profile.

Only contradictions within the files are reported. They cannot show how well the numbers fit a real
robot.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.findings import Finding, Severity, finding_of
from pirate_sm.checking.robot import profile_behaviour, profile_numbers, wheels_and_clamps
from pirate_sm.checking.robot.check_chart import check_chart, cut_off, examine
from pirate_sm.checking.robot.references import OF_PROFILE, found_by, references
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import Document, LoadError, Problem, Problems, read_extended
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.loading import LoadedRobot, cached_table, load_robot, outline_chart, read_robot

UNREACHABLE = "chart.unreachable"

_QUOTED = re.compile(r"'([^']+)'")
_UNKNOWN = {"robot.joint", "robot.roll", "robot.slot", "robot.wheel"}
"""Codes of references that lead nowhere."""


class RobotCheck(NamedTuple):
    """The result of checking a robot's folder.

    Attributes:
        findings: The findings, ordered by place.
        documents: The profile and the chart, as far as they are readable.
        loaded: The robot; None if it cannot be loaded.
    """

    findings: tuple[Finding, ...]
    documents: tuple[Document, ...]
    loaded: LoadedRobot | None


def check_robot(folder: Path) -> RobotCheck:
    """Return the result of checking the robot in this folder."""
    try:
        loaded = load_robot(folder)
    except LoadError as error:
        documents = _readable(folder)
        found = _of_loading(error.problems, documents)
        return RobotCheck((*found, *_besides(folder, found)), documents, None)
    findings = sorted((*check_chart(loaded), *robot_findings(loaded)), key=lambda each: each.order)
    return RobotCheck(tuple(findings), loaded.documents, loaded)


ERROR_RULES = (
    references,
    profile_numbers.never_done,
    profile_numbers.turning_at_rest,
    profile_numbers.link_times,
    profile_numbers.end_stops,
    wheels_and_clamps.wheel_directions,
    wheels_and_clamps.mirrored_slots,
    wheels_and_clamps.safe_clamps,
    profile_behaviour.impossible_signs,
)
"""The rules about robots, except their charts, that report errors, for which runs are refused."""

RULES = (
    *ERROR_RULES,
    profile_behaviour.command_targets,
    profile_behaviour.travel_missions,
    profile_behaviour.fault_conditions,
    profile_behaviour.rule_conditions,
    profile_numbers.impossible_bodies,
    profile_numbers.nominal_times,
    profile_numbers.position_loops,
    profile_numbers.coarse_setpoints,
    profile_numbers.hidden_motors,
    profile_numbers.hidden_words,
    wheels_and_clamps.unconfirmed_clamps,
    wheels_and_clamps.refused_openings,
    wheels_and_clamps.boards_outside,
    wheels_and_clamps.states_alike,
    profile_behaviour.unseen_states,
)
"""These and those that only warn; each yields the findings of a `RobotView`."""


@lru_cache(maxsize=8)
def robot_errors(loaded: LoadedRobot) -> tuple[Finding, ...]:
    """Return the errors of a loaded robot, for which a run is refused."""
    view = RobotView(loaded)
    found = (*check_chart(loaded), *(each for rule in ERROR_RULES for each in rule(view)))
    return tuple(each for each in found if each.severity is Severity.ERROR)


def robot_findings(loaded: LoadedRobot) -> tuple[Finding, ...]:
    """Return the findings about a robot's profile, ordered by place."""
    view = RobotView(loaded)
    found = [finding for rule in RULES for finding in rule(view)]
    return tuple(sorted(found, key=lambda each: each.order))


# --- a robot that cannot be loaded -------------------------------------------------------------


def _readable(folder: Path) -> tuple[Document, ...]:
    """Return the robot's files, as far as they are readable."""
    try:
        profile = read_extended(folder / PROFILE_FILE)
    except LoadError:
        return ()
    name = profile.data.get("chart") if isinstance(profile.data, dict) else None
    try:
        return profile, read_extended(folder / str(name))
    except LoadError:
        return (profile,)


def _besides(folder: Path, found: tuple[Finding, ...]) -> Iterator[Finding]:
    """Yield wrong references, without those of what the faults name that kept it from loading."""
    if any(each.code in _UNKNOWN for each in found):
        return  # what they would name is missing
    try:
        robot, _ = read_robot(folder)
    except LoadError:
        return
    lines = {(each.place.file, each.place.line) for each in found}
    named = {name for each in found for name in _QUOTED.findall(each.message)}
    view = RobotView(robot)
    for each in (*found_by(OF_PROFILE, view), *profile_behaviour.travel_missions(view)):
        follows = named.intersection(_QUOTED.findall(each.message))
        if (each.place.file, each.place.line) not in lines and not follows:
            yield each


def _of_loading(
    problems: tuple[Problem, ...], documents: tuple[Document, ...]
) -> tuple[Finding, ...]:
    """Return the problems as findings, with unreachable states replaced by their cause."""
    rest = [finding_of(each) for each in problems if each.code != UNREACHABLE]
    if len(rest) < len(problems):
        rest += _unreachable([each for each in problems if each.code == UNREACHABLE], documents[1])
    return tuple(sorted(rest, key=lambda each: each.order))


def _unreachable(problems: list[Problem], document: Document) -> list[Finding]:
    collected = Problems(document)
    outline = outline_chart(document, collected)
    assert outline is not None  # it has been explored
    checked = examine(document, outline, cached_table(document, outline, collected))
    excused = {
        document.place_of(outline.place_of(region, state), key=True)
        for region, state in cut_off(outline, checked.silent)
    }
    alone = [finding_of(each) for each in problems if each.place not in excused]
    return [*checked.findings, *alone]

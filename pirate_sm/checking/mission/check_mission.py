"""Check a mission: load it, explore everything that can happen to it, and run the rules."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.exploring.exploration import Explored
from pirate_sm.checking.exploring.explore import explore_corrected, explore_mission
from pirate_sm.checking.findings import Finding, finding_of
from pirate_sm.checking.mission.mission_parameters import parameter_limits, unused_parameters
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.checking.mission.out_of_reach import out_of_reach
from pirate_sm.checking.mission.reachability import branches, reachability, refused_steps
from pirate_sm.checking.mission.time_and_order import (
    beyond_the_limit,
    counts_what_was_counted,
    fault_handlers,
    faults_again,
    ignored_holding,
    resumes_in_vain,
    rises_while_loose,
    time_limits,
)
from pirate_sm.checking.mission.wait_triggers import wait_triggers
from pirate_sm.checking.pipe.check_in_pipe import pipe_findings, view_in_pipe
from pirate_sm.checking.robot.check_robot import robot_errors
from pirate_sm.core.documents import Document, LoadError
from pirate_sm.core.loading import TOLERABLE, LoadedMission, load_mission


@dataclass(frozen=True)
class MissionCheck:
    """The result of checking a mission and its files.

    Attributes:
        loaded: The mission; None if it cannot be loaded.
        documents: The files that were read, as far as they are known.
        explored: Explorations: of the mission as it is, then without impossible steps.
    """

    findings: tuple[Finding, ...]
    documents: tuple[Document, ...] = ()
    loaded: LoadedMission | None = None
    explored: tuple[Explored, ...] = ()


class _Noted(NamedTuple):
    found: dict[Path, MissionCheck]
    loaded: Callable[[Path], None]


_noted: ContextVar[_Noted | None] = ContextVar("noted", default=None)


@contextmanager
def noting_missions(loaded: Callable[[Path], None]) -> Iterator[dict[Path, MissionCheck]]:
    """Return a context that collects the checks of missions in this process, by their files.

    Args:
        loaded: Called with the file of each mission that can be loaded, before it is explored.
    """
    noted = _Noted({}, loaded)
    before = _noted.set(noted)
    try:
        yield noted.found
    finally:
        _noted.reset(before)


def check_mission(
    path: Path,
    *,
    robot: str | None = None,
    pipe: str | None = None,
    settings: Mapping[str, str] | None = None,
) -> MissionCheck:
    """Return the result of checking a mission.

    Args:
        path: The mission's file.
        robot: A robot that overrides the mission's.
        pipe: A pipe that overrides the mission's.
        settings: Values of parameters, as text.

    Raises:
        UsageError: An argument does not fit the mission.
    """
    try:
        loaded = load_mission(path, robot=robot, pipe=pipe, settings=settings, tolerated=TOLERABLE)
    except LoadError as error:
        return MissionCheck(tuple(finding_of(problem) for problem in error.problems))
    noted = _noted.get()
    if noted is not None:
        noted.loaded(path)
    checked = check_loaded(loaded, tuple(map(finding_of, loaded.problems)))
    if noted is not None:
        noted.found[path] = checked
    return checked


def check_loaded(loaded: LoadedMission, told: tuple[Finding, ...] = ()) -> MissionCheck:
    """Explore a loaded mission, and apply all rules to it; errors of its robot are reported too.

    Args:
        loaded: The mission.
        told: Findings of the loader.
    """
    explored, conditions = explore_mission(loaded)
    in_pipe = view_in_pipe(loaded)
    view = MissionView(loaded, MissionPlaces(loaded), conditions, explored, explored, in_pipe)
    found = _judge(view)
    if any(each.code in _NEVER for each in found):
        corrected = explore_corrected(explored, loaded, conditions)
        found = _judge(replace(view, seen=[*explored, *corrected])) if corrected else found
    of_robot = robot_errors(loaded.loaded_robot)
    unique = {(each.code, each.place, each.message): each for each in (*told, *of_robot, *found)}
    ordered = sorted(unique.values(), key=lambda each: each.order)
    return MissionCheck(tuple(ordered), loaded.documents, loaded, tuple(explored))


def _judge(view: MissionView) -> list[Finding]:
    """Return the findings of all rules, without consequences of others at the same place."""
    found = [finding for rule in RULES for finding in rule(view)]
    decided = {each.place for each in found if each.code in _DECIDED}
    cause = {each.code for each in found}
    found = [each for each in found if _FROM.get(each.code, "") not in cause]
    return [each for each in found if each.code not in _FOLLOWING or each.place not in decided]


def in_its_pipe(view: MissionView) -> Iterator[Finding]:
    """Yield findings about the mission in its pipe."""
    if view.in_pipe is not None:
        yield from pipe_findings(view.in_pipe)


def too_large(view: MissionView) -> Iterator[Finding]:
    """Yield a finding if the exploration is not complete."""
    books, loaded, places = view.seen, view.loaded, view.places
    found = next((book.found for book in books if not book.found.complete), None)
    if found is None:
        return
    most = len(found.nodes)
    message = f"more than {most} situations are possible: the others were not explored"
    if found.program is not loaded.program and len(books) > 1:
        message += " (after the steps that cannot run are corrected)"
    at = Counter(found.program.phase_of[node.state.mission.pc] for node in found.nodes)
    phase, number = at.most_common(1)[0]
    fix = (
        f"{number} of them are in the phase '{phase}': give it fewer conditions that depend on "
        "each other, or split the mission and check its parts"
    )
    yield places.finding(places.mission(), "check.too_large", message, fix=fix)


RULES = (
    too_large,
    refused_steps,
    wait_triggers,
    reachability,
    fault_handlers,
    ignored_holding,
    time_limits,
    beyond_the_limit,
    counts_what_was_counted,
    resumes_in_vain,
    faults_again,
    branches,
    out_of_reach,
    in_its_pipe,
    rises_while_loose,
    unused_parameters,
    parameter_limits,
)
"""All rules about missions; each yields the findings of a `MissionView`."""

_DECIDED = frozenset(
    {
        "condition.constant",
        "trigger.at_once",
        "trigger.at_start",
        "trigger.never",
        "trigger.shadowed",
    }
)
"""Codes after which other findings about the same condition are omitted."""

_FOLLOWING = frozenset(
    {
        "branch.always",
        "branch.never",
        "condition.beyond",
        "condition.exact",
        "wait.still",
        "word.held",
        "word.never",
        "word.route",
    }
)
"""Codes that are omitted if one of ``_DECIDED`` is at the same place."""

_FROM = {"word.route": "geometry.too_close", "limit.beyond": "limit.too_short"}
"""Codes that are omitted in a whole mission if another one is found in it."""

_NEVER = frozenset(
    {
        "branch.always",
        "branch.never",
        "condition.beyond",
        "end.unreachable",
        "mission.no_success",
        "phase.unreachable",
        "step.never_needed",
        "trigger.at_once",
        "trigger.at_start",
        "trigger.never",
        "trigger.shadowed",
        "wait.still",
    }
)
"""Codes of things that never happen, but may happen once another fault is corrected."""

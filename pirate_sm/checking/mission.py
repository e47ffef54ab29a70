"""Everything that can be known of a mission before anything moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.explorer import MOST_WORK, explore
from pirate_sm.checking.exploring.ledger import Ledger, ledger
from pirate_sm.checking.exploring.ranges import ranges
from pirate_sm.checking.findings import Finding, Severity, finding_of
from pirate_sm.checking.flow import flow_findings
from pirate_sm.checking.geometry import check_geometry
from pirate_sm.checking.parameters import check_parameters
from pirate_sm.checking.places import Places
from pirate_sm.checking.refusals import refusal_findings
from pirate_sm.checking.waits import wait_findings
from pirate_sm.engine.program import Do, Program, Require
from pirate_sm.loading.mission import TOLERABLE, LoadedMission, read_mission
from pirate_sm.loading.problems import LoadError
from pirate_sm.loading.source import Document

MOST_ASSUMPTIONS = 20
"""How often the exploration is repeated with steps left out that can never run."""


@dataclass(frozen=True)
class MissionCheck:
    """What was found in a mission and the files that it is made of.

    Attributes:
        loaded: The mission, where it has a shape at all.
        documents: Files that were read, as far as is known.
        explored: What can happen, first as it is, then with impossible steps left out.
    """

    findings: tuple[Finding, ...]
    documents: tuple[Document, ...] = ()
    loaded: LoadedMission | None = None
    explored: tuple[Ledger, ...] = ()


def check_mission(
    path: Path,
    *,
    robot: str | None = None,
    pipe: str | None = None,
    settings: Mapping[str, str] | None = None,
    start_phase: str | None = None,
    states: Mapping[str, str] | None = None,
) -> MissionCheck:
    """Everything that is wrong with the mission is known.

    Args:
        path: The mission's file.
        robot: In place of the mission's own.
        pipe: In place of the mission's own.
        settings: Values of parameters, as text.
        start_phase: The phase to begin with.
        states: The states to begin in.

    Raises:
        UsageError: An argument does not fit.
    """
    try:
        loaded, problems = read_mission(
            path, robot=robot, pipe=pipe, settings=settings, start_phase=start_phase,
            states=states, tolerated=TOLERABLE,
        )  # fmt: skip
    except LoadError as error:
        return MissionCheck(tuple(finding_of(problem) for problem in error.problems))
    told = tuple(finding_of(problem) for problem in problems.all)
    return check_loaded(loaded, told)


def check_loaded(loaded: LoadedMission, told: tuple[Finding, ...] = ()) -> MissionCheck:
    """Everything that can happen to a loaded mission has been explored and judged.

    Args:
        loaded: The mission.
        told: What loading has found already.
    """
    books = _explored(loaded)
    places = Places(loaded)
    findings = [*told, *_cut_off(books, places)]
    findings += refusal_findings(books, loaded, places)
    findings += wait_findings(books, loaded, places)
    findings += flow_findings(books, loaded, places)
    findings += check_geometry(loaded)
    findings += check_parameters(loaded.mission, loaded.documents[0])
    unique = {(each.code, each.place, each.message): each for each in findings}
    ordered = sorted(unique.values(), key=lambda each: each.order)
    return MissionCheck(tuple(ordered), loaded.documents, loaded, tuple(books))


def conditions_of(loaded: LoadedMission) -> Conditions:
    """What decides whether conditions on the mission's robot can be true."""
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    return Conditions(loaded.robot.vocabulary, spans, len(loaded.robot.regions))


def _explored(loaded: LoadedMission) -> list[Ledger]:
    """What can happen; and again with the steps left out that can never run, until there are none.

    After a certain refusal the check goes on as if the step were not there, so that later faults
    show as well. All of it together may take as much as one exploration.
    """
    conditions = conditions_of(loaded)
    program = loaded.program
    books: list[Ledger] = []
    left: float = MOST_WORK
    for _ in range(MOST_ASSUMPTIONS):
        book = ledger(explore(loaded.robot, program, conditions, most_work=left))
        left -= book.found.work
        known = {place for earlier in books for place in earlier.visits}
        books.append(book)
        stuck = {
            place
            for place, visits in book.visits.items()
            if place not in known and visits.never_fine
        }
        if not stuck or not book.found.complete:
            break
        program = _without(program, stuck)
    return books


def _without(program: Program, places: set[str]) -> Program:
    """The program with the steps at these places left out."""
    instructions = tuple(
        Require((), "", each.next, each.failed, "")
        if isinstance(each, Do | Require) and each.place in places
        else each
        for each in program.instructions
    )
    return replace(program, instructions=instructions)


def _cut_off(books: Sequence[Ledger], places: Places) -> list[Finding]:
    if all(book.found.complete for book in books):
        return []
    most = len(books[-1].found.nodes)
    message = f"more than {most} situations can come about: what is beyond was not looked at"
    if len(books) > 1:
        message += " (once the steps that cannot run have been mended)"
    return [places.finding(places.mission(), "check.too_large", Severity.WARNING, message)]

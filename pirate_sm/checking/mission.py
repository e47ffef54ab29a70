"""Everything that can be known of a mission before anything moves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pirate_sm.checking.branches import branch_findings
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.explorer import MOST_WORK, explore
from pirate_sm.checking.exploring.ledger import Ledger, ledger
from pirate_sm.checking.exploring.ranges import ranges
from pirate_sm.checking.findings import Finding, Severity, finding_of
from pirate_sm.checking.flow import flow_findings
from pirate_sm.checking.handlers import handler_findings
from pirate_sm.checking.mission_in_pipe import check_in_pipe
from pirate_sm.checking.parameters import check_limits, check_parameters
from pirate_sm.checking.places import Places
from pirate_sm.checking.reach import reach_findings, within_reach
from pirate_sm.checking.refusals import refusal_findings
from pirate_sm.checking.times import time_findings
from pirate_sm.checking.waits import wait_findings
from pirate_sm.engine.mission.program import Do, Program, Raise, Require, Say
from pirate_sm.loading.mission import TOLERABLE, LoadedMission, read_mission
from pirate_sm.loading.problems import LoadError
from pirate_sm.loading.yaml.document import Document

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
    judged = _judged(books, books, loaded, places)
    if any(each.code in _NEVER for each in judged):
        beyond = _beyond(books, loaded)
        judged = _judged(books, [*books, *beyond], loaded, places) if beyond else judged
    findings = [*told, *judged, *check_in_pipe(loaded)]
    findings += check_parameters(loaded.mission, loaded.documents[0])
    findings += check_limits(loaded, within_reach(loaded))
    unique = {(each.code, each.place, each.message): each for each in findings}
    ordered = sorted(unique.values(), key=lambda each: each.order)
    return MissionCheck(tuple(ordered), loaded.documents, loaded, tuple(books))


_DECIDED = frozenset({"condition.constant", "trigger.never", "trigger.shadowed", "trigger.at_once"})
"""Codes of conditions of which nothing more need be said."""

_NEVER = frozenset(
    {
        "branch.never", "branch.always", "condition.beyond", "wait.still",
        "phase.unreachable", "end.unreachable", "trigger.never", "trigger.shadowed",
        "trigger.at_once", "step.never_needed", "mission.no_success",
    }
)  # fmt: skip
"""Codes of what never happens; it may happen once another fault is mended."""


def _judged(
    books: Sequence[Ledger], seen: Sequence[Ledger], loaded: LoadedMission, places: Places
) -> list[Finding]:
    """What is wrong with what can happen."""
    found = [
        *_cut_off(seen, loaded, places),
        *refusal_findings(books, seen, loaded, places),
        *wait_findings(books, seen, loaded, places),
        *flow_findings(books, seen, loaded, places),
        *handler_findings(loaded),
        *time_findings(books, loaded, places),
    ]
    told = {each.place for each in found if each.code in _DECIDED}
    more = [*branch_findings(seen, loaded, places), *reach_findings(seen, loaded, places)]
    return [*found, *(each for each in more if each.place not in told)]


def conditions_of(loaded: LoadedMission) -> Conditions:
    """What decides whether conditions on the mission's robot can be true."""
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    return Conditions(loaded.robot.vocabulary.with_changes, spans, len(loaded.robot.regions))


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
    """The program with the steps at these places left out; of a call all that it does."""
    instructions = tuple(
        Require((), "", _after(program, index), each.failed, "")
        if isinstance(each, Do | Require) and each.place in places
        else each
        for index, each in enumerate(program.instructions)
    )
    return replace(program, instructions=instructions)


def _after(program: Program, index: int) -> int:
    """Where it goes on after a step; a call is followed by what each of its ends leads to."""
    step = program.instructions[index]
    assert isinstance(step, Do | Require)
    if isinstance(step, Do):
        return step.next
    for end in program.instructions[index + 1 :]:
        if isinstance(end, Say):
            return end.next
        if not isinstance(end, Raise):
            break
    return step.next  # it has no end that succeeds


def _beyond(books: Sequence[Ledger], loaded: LoadedMission) -> list[Ledger]:
    """What can happen once steps that are refused on some path, and broken rules, are mended.

    What is reached, needed or fired only then is no fault of its own: it is told of nothing that
    it never is.
    """
    last = books[-1]
    refused = {place for book in books for place, visits in book.visits.items() if visits.refused}
    broken = any(book.broken for book in books)
    if not last.found.complete or not (refused or broken):
        return []
    program = last.found.program
    instructions = tuple(
        each._replace(failed=_after(program, index))
        if isinstance(each, Do | Require) and each.place in refused
        else each
        for index, each in enumerate(program.instructions)
    )
    mended = replace(program, instructions=instructions, rules=() if broken else program.rules)
    left = MOST_WORK - sum(book.found.work for book in books)
    return [ledger(explore(loaded.robot, mended, conditions_of(loaded), most_work=left))]


def _cut_off(books: Sequence[Ledger], loaded: LoadedMission, places: Places) -> list[Finding]:
    found = next((book.found for book in books if not book.found.complete), None)
    if found is None:
        return []
    most = len(found.nodes)
    message = f"more than {most} situations can come about: what is beyond was not looked at"
    if found.program is not loaded.program and len(books) > 1:
        message += " (once the steps that cannot run have been mended)"
    at = Counter(found.program.phase_of[node.state.mission.pc] for node in found.nodes)
    phase, number = at.most_common(1)[0]
    mend = (
        f"{number} of them are in the phase '{phase}': give it fewer conditions that depend on "
        "each other, or split the mission and check its parts"
    )
    return [places.finding(places.mission(), "check.too_large", Severity.ERROR, message, mend=mend)]

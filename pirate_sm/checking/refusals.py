"""Steps that cannot run, on every path or on some, and calls whose terms are not met."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from pirate_sm.checking.exploring.ledger import Ledger, Visits
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.places import Places
from pirate_sm.engine.program import STOP, Do, Program, Require
from pirate_sm.loading.mission import LoadedMission


def refusal_findings(
    books: Sequence[Ledger], seen: Sequence[Ledger], loaded: LoadedMission, places: Places
) -> Iterator[Finding]:
    """One finding for each step that is refused on some path, from where it is first seen.

    Args:
        books: What can happen.
        seen: That, and what can happen once other faults are mended.
        loaded: The mission.
        places: Of its parts.
    """
    steps = {
        each.place: each
        for each in loaded.program.instructions
        if isinstance(each, Do | Require) and each.place
    }
    handlers = handler_phases(loaded.program)
    phases = _phases(loaded.program)
    done: set[str] = set()
    for number, book in enumerate(books):
        assumed = number > 0
        for place, visits in book.visits.items():
            if place in done or place not in steps:
                continue
            done.add(place)
            step = steps[place]
            if _needed(place, seen) and not visits.refused:
                continue
            name = places.written(place, visits.name)
            found = _judge(book, visits, name, step, phases[place] & handlers)
            if found is None:
                continue
            code, severity, message, step_number, mend = found
            if assumed:
                message += " (once the step before that cannot run has been mended)"
            yield places.finding(
                places.read(place), code, severity, message, mend=mend,
                happens=(book.found, step_number) if step_number >= 0 else None,
                playable=not assumed,
            )  # fmt: skip


def handler_phases(program: Program) -> frozenset[str]:
    """Phases that failures and faults lead to."""
    targets = {
        each.failed
        for each in program.instructions
        if isinstance(each, Do | Require) and each.failed not in {STOP, each.next}
    }
    targets |= {
        handler.go for each in program.handlers for handler in each if handler.go is not None
    }
    return frozenset(program.phase_of[target] for target in targets) - {""}


def _phases(program: Program) -> dict[str, set[str]]:
    """The phases in which the step at each place stands; a called one stands in several."""
    found: dict[str, set[str]] = defaultdict(set)
    for each, phase in zip(program.instructions, program.phase_of, strict=True):
        if isinstance(each, Do | Require):
            found[each.place].add(phase)
    return found


def _needed(place: str, seen: Sequence[Ledger]) -> bool:
    """Whether the step is given anywhere."""
    return any(place in book.visits and book.visits[place].given for book in seen)


def _judge(
    book: Ledger, visits: Visits, name: str, step: Do | Require, handling: set[str]
) -> tuple[str, Severity, str, int, str] | None:
    """Code, severity, message, step to be told, and how to mend it; None where all is well."""
    complete = book.found.complete
    if isinstance(step, Do) and not visits.given and not visits.refused and complete:
        message = f"{name} is never needed: it is so already whenever its turn comes"
        return "step.never_needed", Severity.WARNING, message, -1, "leave the step out"
    if not visits.refused:
        return None
    always = visits.never_fine and complete
    if isinstance(step, Do) and step.expected and not always:
        return None  # the step itself says where its refusal leads
    first = _first(book, visits)
    severity = Severity.ERROR if book.sure(first) else Severity.POSSIBLE
    reason = visits.reasons[first]
    code = _code(visits, step, first, handling, "" if always else "maybe_")
    word = "is refused" if always else "can be refused"
    message = f"{name} {word} as {reason}"
    if always and len({visits.reasons[each] for each in visits.refused}) > 1:
        message += ", or for another reason, on every path"
    return code, severity, message, first, _mend(visits, step, first, always=always)


def _first(book: Ledger, visits: Visits) -> int:
    """The refusal to be told: a sure one if there is, and of these the first."""
    sure = [each for each in visits.refused if book.sure(each)]
    return min(sure or visits.refused)


def _code(visits: Visits, step: Do | Require, first: int, handling: set[str], maybe: str) -> str:
    if isinstance(step, Require):
        return f"call.{maybe}starts_in"
    if handling:
        return "handler.impossible"
    kind = "unneeded" if first in visits.unneeded else "impossible"
    return f"step.{maybe}{kind}"


def _mend(visits: Visits, step: Do | Require, first: int, *, always: bool) -> str:
    if isinstance(step, Require):
        return "bring the robot into the states that the called mission starts in"
    if first in visits.unneeded:
        if always:
            return "leave the step out, or say `unneeded: skip`"
        return "say `unneeded: skip`: then it is passed over where it is not needed"
    return "put the commands before it that make it possible, or say `on_failure` at the step"

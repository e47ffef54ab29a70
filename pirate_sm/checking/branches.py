"""Steps behind an `if`, and arms of a `choose`, that are never or always taken."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from pirate_sm.checking.exploring.ledger import Ledger
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.places import Places
from pirate_sm.engine.program import Branch
from pirate_sm.loading.mission import LoadedMission


def branch_findings(
    seen: Sequence[Ledger], loaded: LoadedMission, places: Places
) -> Iterator[Finding]:
    """What is decided already wherever it is asked, in the mission's own file.

    A called mission is judged by itself: it may be called from elsewhere too. What asks for
    states that no command has changed yet guards against another beginning, and is no fault; nor
    is what asks again for what a trigger has just seen.

    Args:
        seen: What can happen.
        loaded: The mission.
        places: Of its parts.
    """
    if not all(book.found.complete for book in seen):
        return
    truths: dict[str, set[bool]] = defaultdict(set)
    guards = set[str]()
    for book in seen:
        for where, asked in book.found.branches.items():
            for each in asked:
                truths[where].add(each.truth)
                if not each.moved:
                    guards.add(where)
    conditions = {
        each.place: each.condition.text
        for each in loaded.program.instructions
        if isinstance(each, Branch)
    }
    for where, text in conditions.items():
        place = places.read(where)
        if place.file != loaded.documents[0].name or len(truths[where]) != 1:
            continue
        if where in guards:
            continue
        if True in truths[where]:
            yield places.finding(
                place, "branch.always", Severity.WARNING,
                f"'{text}' is true whenever it is asked", mend="leave the condition out",
            )  # fmt: skip
        else:
            yield places.finding(
                place, "branch.never", Severity.WARNING,
                f"'{text}' is never true when it is asked", mend="leave the steps out",
            )  # fmt: skip

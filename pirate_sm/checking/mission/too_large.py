"""A rule about size: a mission is too large for a complete exploration."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.mission_view import MissionView


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
    mend = (
        f"{number} of them are in the phase '{phase}': give it fewer conditions that depend on "
        "each other, or split the mission and check its parts"
    )
    yield places.finding(places.mission(), "check.too_large", message, mend=mend)

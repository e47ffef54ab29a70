"""A short form of `python -m benchmarks.resume`: missions cut off, resumed, judged by the truth."""

from __future__ import annotations

import pytest
from representative import thorough_but

from benchmarks.resume_rides import KINDS, LIES, Case, missions, ride
from pirate_sm.core import library

MISSION = "prepare_bend"
"""The shortest mission that clamps, bends and drives."""


@pytest.mark.parametrize("kind", thorough_but(["runner", "power"], KINDS))
@pytest.mark.parametrize("share", thorough_but([0.9], [0.3, 0.9]))
def test_whatever_dies_the_mission_goes_on_without_a_let_go(kind: str, share: float) -> None:
    found = ride(Case(MISSION, kind, share, dark_s=1.0))

    assert found.how == "success", found.why


@pytest.mark.thorough
@pytest.mark.parametrize("lie", ["stuck joint", "other robot"])
def test_a_lie_about_what_holds_is_refused(lie: str) -> None:
    found = ride(Case("mitre_bend", "runner", 0.75, 2.0, lie=lie), operator=False)

    assert found.how == "refused", found.why
    assert lie in LIES


@pytest.mark.slow
@pytest.mark.parametrize("mission", [path.stem for path in library.missions()])
@pytest.mark.parametrize("kind", KINDS)
def test_no_mission_lets_go(mission: str, kind: str) -> None:
    if mission not in missions():
        pytest.skip("it runs on no robot with a serial link, or in no pipe")
    found = ride(Case(mission, kind, 0.5, dark_s=1.0))

    assert found.how in ("success", "failure", "refused"), found.why

from __future__ import annotations

import pytest
from late import late

import pirate_sm
from pirate_sm.core.errors import UsageError

from .conftest import PATROL

pd = late("pandas")


@pytest.mark.thorough
def test_every_seed_has_a_row_and_processes_do_not_matter() -> None:
    options = {"start_jitter_m": 0.01, "friction_jitter": 0.1}
    alone = pirate_sm.sweep(PATROL, range(3), workers=1, **options)  # type: ignore[arg-type]

    assert alone["seed"] == [0, 1, 2]
    assert alone["outcome"] == ["succeeded"] * 3
    assert len(set(alone["duration_s"])) > 1
    assert pd.DataFrame(alone).shape == (3, 5)
    loaded = pirate_sm.load(PATROL)
    assert pirate_sm.sweep(loaded, range(3), workers=2, **options) == alone  # type: ignore[arg-type]


def test_a_fast_sweep_is_coarser_and_its_rows_are_those_of_fast_runs() -> None:
    usual = pirate_sm.sweep(PATROL, [7])
    fast = pirate_sm.sweep(PATROL, [7], fidelity="fast")

    run = pirate_sm.run(PATROL, seed=7, fidelity="fast")

    assert fast["outcome"] == usual["outcome"] == ["succeeded"]
    assert fast["duration_s"] == [run.duration_s]
    assert fast["duration_s"] == pytest.approx(usual["duration_s"], rel=0.05)
    with pirate_sm.session(PATROL, fidelity="fast") as session:
        assert session.run.header.fidelity == "fast"


def test_a_row_can_be_repeated_as_a_run() -> None:
    row = pirate_sm.sweep(PATROL, [7], start_jitter_m=0.01)

    run = pirate_sm.run(PATROL, seed=7, start_jitter_m=0.01)

    assert (run.outcome, run.duration_s) == (row["outcome"][0], row["duration_s"][0])


@pytest.mark.thorough
def test_a_mission_can_be_swept_from_another_phase() -> None:
    table = pirate_sm.sweep(
        PATROL, range(2), backend="trace", start_phase="home", states={"Grip": "BothHeld"}
    )

    assert table["end"] == ["back", "back"]


def test_what_does_not_fit_is_refused_before_any_process_starts() -> None:
    with pytest.raises(pirate_sm.UsageError, match="rust"):
        pirate_sm.sweep(PATROL, range(2), defects=["rust"])


def test_a_sweep_without_seeds_is_refused() -> None:
    with pytest.raises(UsageError, match="a sweep has one seed at least"):
        pirate_sm.sweep(PATROL, [])

from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.experiments.experiment_files import chosen, load_experiments, parts_of
from pirate_sm.lab.experiments.thesis_rows import compared

ROBOT = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"


def names(which: list[str]) -> list[str]:
    return [part for _, parts in chosen(load_experiments(ROBOT), which) for part in parts]


def test_every_experiment_of_the_thesis_is_there() -> None:
    assert names(["all"]) == [
        *("1a", "1b", "1c", "1d"),
        *("2a", "2b", "2c"),
        *("3a", "3b", "3c", "3d"),
    ]


def test_a_number_means_all_of_its_parts_and_nothing_is_run_twice() -> None:
    assert names(["2", "3c", "2a"]) == ["2a", "2b", "2c", "3c"]


def test_an_unknown_one_is_refused() -> None:
    with pytest.raises(UsageError, match="no experiment '4'"):
        names(["4"])


def test_every_row_is_of_a_part_and_has_a_reason() -> None:
    for setup in load_experiments(ROBOT):
        for row in setup.rows:
            assert row.of in parts_of(setup)
            assert row.reason, row.what


def test_no_slip_ratio_of_driving_is_predicted_by_wheels_that_do_not_slip() -> None:
    """Eighteen rows once had a band of 0.3 either way, which such wheels pass."""
    (setup,) = (each for each in load_experiments(ROBOT) if each.experiment == 1)
    rows = [row for row in setup.rows if "driving, m" in row.what]
    verdicts = {each.verdict for each in compared(rows, dict.fromkeys((r.ours for r in rows), 0.0))}

    assert len(rows) > 30
    assert verdicts == {"consistent with no effect", "contradicted"}

from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.experiments.experiment_files import chosen, load_experiments, parts_of

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


def test_every_row_is_of_a_part_and_is_judged_somehow() -> None:
    for setup in load_experiments(ROBOT):
        for row in setup.rows:
            assert row.of in parts_of(setup)
            assert row.cannot or (row.ours and (row.between or row.shape))
            assert row.between is not None or row.reason

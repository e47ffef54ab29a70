import numpy as np
import pytest

from pirate_sm.lab.experiments.slip_histogram import slip_histogram
from pirate_sm.lab.experiments.thesis_rows import ThesisRow

ROW = ThesisRow(
    of="1a",
    what="mean",
    place="table 6-1",
    thesis="-0.1396",
    ours="1a.wheel_5.driving_mean",
    between=(-0.1946, -0.0846),
    source="plus and minus the std.",
    no_effect=0,
)


def test_ours_stands_with_its_number_beside_the_printed_mean_and_spread() -> None:
    plot = slip_histogram([ROW], "1a", "wheel_5", np.full(300, 0.004))
    ours, thesis = plot.series

    assert ours.name == "ours, n = 300"
    width = ours.x[1] - ours.x[0]
    assert sum(ours.y) * width == pytest.approx(1)
    assert sum(thesis.upper) * width == pytest.approx(1, abs=0.01)
    assert thesis.x[int(np.argmax(thesis.upper))] == pytest.approx(-0.1396, abs=width)


def test_without_a_printed_mean_or_without_driving_there_is_ours_alone() -> None:
    (ours,) = slip_histogram([], "1b", "wheel_5", np.array([])).series

    assert not any(ours.y)

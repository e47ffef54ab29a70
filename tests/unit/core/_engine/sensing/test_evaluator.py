"""What single operations of a table of signals give."""

from __future__ import annotations

import math

import pytest

from pirate_sm.core._engine.sensing import evaluator
from pirate_sm.core._engine.sensing.evaluator import loss_after

PERIOD_S = 0.1


def after(operation: int, a: int, b: int, c: int, *cells: float, raw: tuple[float, ...] = ()):
    """The first cell after one row, whose other cells are these; the signals were zero before."""
    values = [math.nan, *cells]
    kept = evaluator.run(
        [(operation, 0, a, b, c)], (), values, [0.0] * len(values), raw, 1.0, PERIOD_S
    )
    return values[0] if kept else None


def loss_over(gaps: list[int], reports: int = 2000) -> float:
    """The share after reports with these gaps, in periods, again and again."""
    loss, total = 0.0, 0.0
    for at in range(reports):
        loss = loss_after(loss, gaps[at % len(gaps)] * PERIOD_S, PERIOD_S)
        total += loss if at >= reports // 2 else 0.0
    return total / (reports - reports // 2)


@pytest.mark.parametrize(
    ("gaps", "lost"), [([1], 0.0), ([2], 0.5), ([4], 0.75), ([1, 1, 1, 2], 0.2), ([3, 1], 0.5)]
)
def test_the_share_is_that_of_the_reports_that_did_not_come(gaps: list[int], lost: float) -> None:
    assert loss_over(gaps) == pytest.approx(lost, abs=0.02)


@pytest.mark.parametrize("elapsed", [0.0, 0.3, 0.9, 1.4])
def test_reports_that_have_waited_together_are_no_loss(elapsed: float) -> None:
    assert loss_after(0.0, elapsed * PERIOD_S, PERIOD_S) == 0.0


def test_one_board_that_was_away_for_long_does_not_make_a_bad_line() -> None:
    assert loss_after(0.0, 600.0, PERIOD_S) < 0.15
    assert loss_after(0.0, math.inf, PERIOD_S) < 0.15, "nor does one that was never heard"


def test_a_raw_value_is_scaled_before_its_zero_is_subtracted() -> None:
    assert after(evaluator.SCALE, 1, 1, 2, 0.5, 3.0, raw=(7.0, 8.0)) == 1.0


def test_a_rate_is_the_change_over_the_time_since_the_frame_before() -> None:
    assert after(evaluator.RATE, 1, 0, 0, 0.2) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("duty", "torque"), [(0.3, 4.0), (-0.3, -4.0), (0.0, 0.0), (math.nan, math.nan)]
)
def test_a_torque_has_the_sign_of_its_setpoint(duty: float, torque: float) -> None:
    shown = after(evaluator.TORQUE, 1, 2, 3, 2.0, duty, 2.0)

    assert shown == torque or (math.isnan(shown) and math.isnan(torque))


@pytest.mark.parametrize("operation", [evaluator.ROLL, evaluator.PITCH])
def test_a_vector_with_an_unknown_axis_has_no_direction(operation: int) -> None:
    assert math.isnan(after(operation, 1, 2, 3, 1.0, math.nan, 0.0))


def test_a_v_that_is_bent_to_an_impossible_angle_spans_nothing_known() -> None:
    assert math.isnan(after(evaluator.DIAMETER, 1, 2, 3, math.inf, 0.1, 0.05))


@pytest.mark.parametrize(
    ("value", "kept"), [(-1.0, True), (2.0, True), (2.1, False), (-1.1, False), (math.nan, False)]
)
def test_a_value_outside_its_range_ends_the_run(value: float, kept: bool) -> None:
    cells = [value, -1.0, 2.0, 0.0]
    rows = [(evaluator.RANGE, 0, 0, 1, 2), (evaluator.HEARD, 3, 0, 0, 0)]

    assert evaluator.run(rows, (), cells, cells, (), 9.0, PERIOD_S) is kept
    assert cells[3] == (9.0 if kept else 0.0)


@pytest.mark.parametrize(
    ("before", "kept"), [(0.0, True), (0.9, True), (-1.5, False), (math.nan, False)]
)
def test_a_value_may_change_as_fast_as_its_motor_and_by_some_slack(
    before: float, kept: bool
) -> None:
    cells = [0.5, 4.0, 0.5]

    assert evaluator.run([(evaluator.STEP, 0, 0, 1, 2)], (), cells, [before], (), 1, 0.1) is kept

from __future__ import annotations

from collections.abc import Callable
from math import asin, cos, degrees, isnan, nan, pi, radians, sin
from pathlib import Path

import pytest
from driving import NEWT, PIRATE, Driver, changed_newt

from pirate_sm.core import effects as fx
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._model import events as ev

Drive = Callable[..., Driver]

G = 9.81
LEAN = asin((0.120 - 0.048) / 0.090)
"""Of a link of 90 mm that reaches from wall to wall in 120 mm."""

OBLIQUE = asin((0.120 - 0.048) / 0.098)
"""Of the link with the accelerometer."""

FRONT = {"gamma_1": -2 * LEAN, "gamma_2": LEAN + OBLIQUE}
REAR = {"gamma_3": -(LEAN + OBLIQUE), "gamma_4": 2 * LEAN}
BOTH = "FrontWheelsState: Fixed, RearWheelsState: Fixed, BendingState: DoubleClamped"
FRONT_ONLY = "FrontWheelsState: Fixed, BendingState: FrontClampedRearRelaxed"
REAR_ONLY = "RearWheelsState: Fixed, BendingState: RearClampedFrontRelaxed"


def felt(pitch_deg: float = 0.0, roll_deg: float = 0.0, lean: float = OBLIQUE) -> dict[str, float]:
    """What the accelerometer shows on a link that leans to side A against the pipe."""
    pitch, roll = radians(pitch_deg), radians(roll_deg)
    along, side_b, up = G * sin(pitch), -G * cos(pitch) * sin(roll), G * cos(pitch) * cos(roll)
    return {
        "acc_x": along * cos(lean) - side_b * sin(lean),
        "acc_y": along * sin(lean) + side_b * cos(lean),
        "acc_z": up,
    }


@pytest.fixture
def holding(drive: Drive) -> Callable[..., Driver]:
    """The robot waits in a configuration, with its sensors as given, for a second and more."""

    def start(states: str, for_s: float = 1.5, **signals: float) -> Driver:
        driver = drive(f"""
starts_in: {{{states}}}
start: a
phases: {{a: {{wait: [{{operator: on, go: e}}], within: {{time: 1 h, go: e}}}}}}
ends: {{e: {{succeed: ok}}}}
""")
        driver.signals |= signals
        driver.run(for_s)
        return driver

    return start


def last(driver: Driver) -> fx.Environment:
    return driver.of(fx.Environment)[-1]


@pytest.mark.parametrize("states", [BOTH, FRONT_ONLY, REAR_ONLY])
@pytest.mark.parametrize(("pitch", "roll"), [(0, 0), (28, 0), (-28, 10), (60, -35), (5, 170)])
def test_the_oblique_link_is_turned_into_the_axis_of_the_pipe(
    holding: Callable[..., Driver], states: str, pitch: float, roll: float
) -> None:
    report = last(holding(states, **FRONT, **REAR, **felt(pitch, roll)))
    assert degrees(report.pitch_rad) == pytest.approx(pitch, abs=0.3)
    assert degrees(report.roll_rad) == pytest.approx(roll, abs=0.3)
    assert report.diameter_m == pytest.approx(0.120, abs=2e-4)
    assert report.segment == "Straight"


def test_the_rear_is_seen_through_the_roll_joint(holding: Callable[..., Driver]) -> None:
    # The module lies along the pipe; its front half is rolled by 90 deg against the rear.
    signals = {**REAR, "gamma_3": -LEAN, "phi": pi / 2, **felt(10, 100, lean=0.0)}
    report = last(holding(REAR_ONLY, **signals))
    assert degrees(report.roll_rad) == pytest.approx(10.0, abs=0.3)
    assert degrees(report.pitch_rad) == pytest.approx(10.0, abs=0.3)


def test_an_upright_pipe_has_no_roll(holding: Callable[..., Driver]) -> None:
    report = last(holding(BOTH, **FRONT, **REAR, **felt(89)))
    assert degrees(report.pitch_rad) == pytest.approx(89, abs=0.5)
    assert isnan(report.roll_rad)


def test_nothing_is_known_without_a_confirmed_clamp(holding: Callable[..., Driver]) -> None:
    driver = holding("BendingState: Unclamped", **felt(28))
    assert driver.of(fx.Environment) == []
    assert driver.state.outside("segment") is None


@pytest.mark.parametrize(
    ("joint", "known"), [("gamma_1", False), ("gamma_2", False), ("gamma_3", True)]
)
def test_pitch_is_unknown_where_a_joint_is_that_it_rests_on(
    holding: Callable[..., Driver], joint: str, known: bool
) -> None:
    report = last(holding(FRONT_ONLY, **{**FRONT, **REAR, **felt(28), joint: nan}))
    assert isnan(report.pitch_rad) != known
    assert isnan(report.diameter_m) != known  # the front is not seen to hold any more


def test_parts_that_show_different_diameters_show_none(holding: Callable[..., Driver]) -> None:
    report = last(holding(BOTH, **{**FRONT, **REAR, "gamma_4": 1.2}, **felt()))
    assert isnan(report.diameter_m)


def test_a_clamp_at_its_end_stop_has_no_wall(holding: Callable[..., Driver]) -> None:
    stop = load_robot(PIRATE).normal.body.parts[0].end_stop_rad
    driver = holding(FRONT_ONLY, gamma_1=radians(1) - stop, gamma_2=0.0, **felt())
    assert last(driver).segment == "Out"
    assert driver.state.outside("segment") == "Out"
    assert isnan(last(driver).diameter_m)


def test_two_clamped_parts_along_different_axes_hold_a_joint_between_them(
    holding: Callable[..., Driver],
) -> None:
    bent = {**FRONT, **REAR, "gamma_2": LEAN + OBLIQUE - pi / 2}
    assert last(holding(BOTH, **bent, **felt())).segment == "Joint"


def test_a_bend_is_a_joint_from_its_first_word_to_the_one_that_says_it_is_behind(
    holding: Callable[..., Driver],
) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt())
    segments = []
    for word in ("close", "in", "past"):
        driver.give(ev.DetectorWord(word, 1.0))
        driver.run(driver.now + 0.5)
        segments.append(driver.state.outside("segment"))
    assert segments == ["Joint", "Joint", "Straight"]


@pytest.mark.parametrize(("diameter_m", "known"), [(0.120, True), (0.118, True), (0.102, False)])
def test_a_part_that_stands_askew_in_a_bend_shows_no_diameter_and_no_pitch(
    holding: Callable[..., Driver], diameter_m: float, known: bool
) -> None:
    driver = holding(FRONT_ONLY, **FRONT, **felt(28))
    driver.give(ev.DetectorWord("close", 60.0))
    driver.signals["gamma_1"] = -2 * asin((diameter_m - 0.048) / 0.090)
    driver.run(driver.now + 3.0)
    assert last(driver).segment == "Joint"
    assert isnan(last(driver).diameter_m) != known
    assert isnan(last(driver).pitch_rad) != known


def test_a_part_alone_in_a_bend_shows_nothing_where_no_straight_was_seen_before(
    holding: Callable[..., Driver],
) -> None:
    driver = holding(FRONT_ONLY, 0.1, **FRONT, **felt(28))
    driver.give(ev.DetectorWord("close", 60.0))
    driver.run(driver.now + 3.0)
    assert last(driver).segment == "Joint"
    assert isnan(last(driver).diameter_m)
    assert isnan(last(driver).pitch_rad)


def test_a_bend_of_which_no_word_is_valid_any_more_is_unknown(
    holding: Callable[..., Driver],
) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt())
    driver.give(ev.DetectorWord("close", 0.5))
    driver.run(driver.now + 1.0)
    assert last(driver).segment == ""
    assert driver.state.outside("segment") is None


def test_noise_is_not_reported(holding: Callable[..., Driver]) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt(20))
    before = len(driver.of(fx.Environment))
    for step in range(100):
        driver.signals |= felt(20 + 0.4 * (-1) ** step)
        driver.signals["gamma_1"] = -2 * LEAN + 0.005 * (-1) ** step
        driver.run(driver.now + 0.1)
    assert len(driver.of(fx.Environment)) == before


def test_a_jolt_is_not_gravity(holding: Callable[..., Driver]) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt(20))
    before = len(driver.of(fx.Environment))
    for jolt in (felt(50), {"acc_x": 60.0}):
        driver.signals |= jolt
        driver.run(driver.now + 0.3)
        driver.signals |= felt(20)
        driver.run(driver.now + 2.0)
    assert len(driver.of(fx.Environment)) == before


def test_a_change_is_reported_once(holding: Callable[..., Driver]) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt(20))
    before = len(driver.of(fx.Environment))
    driver.signals |= felt(23)
    driver.run(driver.now + 5.0)
    assert len(driver.of(fx.Environment)) == before + 1
    assert degrees(last(driver).pitch_rad) == pytest.approx(23, abs=0.3)


def test_a_report_from_outside_counts_while_it_is_valid(holding: Callable[..., Driver]) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt(20))
    driver.give(ev.EnvironmentReport("Joint", 0.1, 0.2, 0.15, valid_for_s=2.0))
    assert last(driver) == fx.Environment("Joint", 0.1, 0.2, 0.15)
    driver.run(driver.now + 1.9)
    assert driver.state.outside("segment") == "Joint"
    driver.run(driver.now + 0.5)
    assert driver.state.outside("segment") == "Straight"
    assert last(driver).diameter_m == pytest.approx(0.120, abs=1e-3)


def test_in_a_trace_only_somebody_outside_reports(drive: Drive) -> None:
    driver = drive(
        """
start: a
phases: {a: {wait: [{operator: on, go: e}], within: {time: 1 h, go: e}}}
ends: {e: {succeed: ok}}
""",
        nominal=True,
    )
    driver.give(ev.EnvironmentReport("Joint", 0.1, 0.2, 0.15, valid_for_s=2.0), 1.0)
    assert driver.wake_at == 3.0
    driver.tick(3.0)
    assert driver.state.outside("segment") is None
    assert [each.segment for each in driver.of(fx.Environment)] == ["Joint", ""]


def test_a_robot_without_an_accelerometer_reports_what_it_can(drive: Drive) -> None:
    driver = drive(
        """
starts_in: {Grip: BothHeld}
start: a
phases: {a: {wait: [{operator: on, go: e}], within: {time: 1 h, go: e}}}
ends: {e: {succeed: ok}}
""",
        NEWT,
    )
    lean = asin((0.100 - 0.040) / 0.080)
    driver.signals |= {"neck": -2 * lean, "hip": 2 * lean}
    driver.run(1.0)
    report = last(driver)
    assert (report.segment, report.diameter_m) == ("Straight", pytest.approx(0.1, abs=1e-3))
    assert isnan(report.pitch_rad)
    assert isnan(report.roll_rad)


# --- the joint ------------------------------------------------------------------------------


def lean_in(diameter_m: float) -> float:
    """Of a link of 90 mm that reaches from wall to wall."""
    return asin((diameter_m - 0.048) / 0.090)


def vees(front_m: float, rear_m: float, axis_rad: float = 0.0) -> dict[str, float]:
    """Two clamped parts in these diameters; the front's axis is turned by this angle."""
    oblique = asin((front_m / 2 + rear_m / 2 - 0.048) / 0.098)
    front, rear = lean_in(front_m), lean_in(rear_m)
    return {
        "gamma_1": -2 * front,
        "gamma_2": front + oblique - axis_rad,
        "gamma_3": -(rear + oblique),
        "gamma_4": 2 * rear,
    }


def test_two_parts_along_one_axis_with_different_diameters_are_in_a_reducer(
    holding: Callable[..., Driver],
) -> None:
    driver = holding(BOTH, **vees(0.110, 0.120), **felt())
    assert last(driver).joint == driver.state.outside("joint") == "reducer"
    assert last(driver).diameter_ahead_m == pytest.approx(0.110, abs=1e-3)


@pytest.mark.parametrize(
    "signals", [vees(0.120, 0.120), vees(0.118, 0.120), vees(0.110, 0.120, radians(4))]
)
def test_what_may_be_noise_or_a_bend_is_no_reducer(
    holding: Callable[..., Driver], signals: dict[str, float]
) -> None:
    driver = holding(BOTH, **signals, **felt())
    assert last(driver).joint == ""
    assert driver.state.outside("joint") is None


def test_a_glimpse_of_another_diameter_is_no_reducer(holding: Callable[..., Driver]) -> None:
    driver = holding(BOTH, **vees(0.120, 0.120), **felt())
    driver.signals |= vees(0.110, 0.120)
    driver.run(driver.now + 0.3)
    driver.signals |= vees(0.120, 0.120)
    driver.run(driver.now + 1.0)
    assert {each.joint for each in driver.of(fx.Environment)} == {""}


def test_a_word_may_announce_the_kind_of_a_joint(drive: Drive, tmp_path: Path) -> None:
    robot = changed_newt(tmp_path, ("    near:\n", "    near:\n      joint: tee\n"))
    driver = drive(
        """
starts_in: {Grip: BothHeld}
start: a
phases: {a: {wait: [{when: joint == tee, go: e}], within: {time: 1 h, go: gone}}}
ends: {e: {succeed: a tee}, gone: {fail: none}}
""",
        robot,
    )
    lean = asin((0.100 - 0.040) / 0.080)
    driver.signals |= {"neck": -2 * lean, "hip": 2 * lean}
    driver.run(1.0)
    driver.give(ev.DetectorWord("near", 1.0))
    driver.run(driver.now + 0.9)
    assert driver.of(fx.TriggerFired)[-1].go == "e"
    assert last(driver).joint == "tee"


def test_a_report_from_outside_leaves_what_it_does_not_know_to_the_signals(
    holding: Callable[..., Driver],
) -> None:
    driver = holding(BOTH, **FRONT, **REAR, **felt(20))
    driver.give(
        ev.EnvironmentReport("", nan, nan, nan, 2.0, "tee", "t1", pi / 2, 0.3, 0.11, "main", 0.7)
    )
    found = last(driver)
    assert found.segment == driver.state.outside("segment") == "Straight"
    assert degrees(found.pitch_rad) == pytest.approx(20, abs=0.3)
    assert found[4:] == ("tee", "t1", pi / 2, 0.3, 0.11, "main", 0.7)
    assert driver.state.outside("joint") == "tee"
    driver.run(driver.now + 2.5)
    assert last(driver).joint == last(driver).run == ""
    assert driver.state.outside("joint") is None

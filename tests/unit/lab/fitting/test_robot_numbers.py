from pathlib import Path

import numpy as np
import pytest

import pirate_sm
from pirate_sm.core._loading.robot.twin import load_twin
from pirate_sm.lab.fitting import robot_numbers as fitted
from pirate_sm.lab.fitting.measurements import (
    Estimate,
    MeasuredFile,
    estimate_of,
    read_measured,
)
from pirate_sm.lab.fitting.motor_intervals import Intervals
from pirate_sm.lab.fitting.robot_numbers import (
    RobotNumber,
    clamp_threshold,
    driven,
    robot_numbers,
    rolling_resistance,
    wheel_numbers,
)
from pirate_sm.lab.fitting.twin_file import twin_text

TRUE = {
    ("wheel", "no_load_speed"): 3.4,
    ("wheel", "stall_torque"): 0.26,
    ("wheel", "hold_torque"): 0.09,
    ("bend", "no_load_speed"): 0.8,
    ("bend", "stall_torque"): 0.9,
}
TWIN = """
format: 1
robot: pirate_ii
motors:
  wheel: {no_load_speed: 3.4 rad/s, stall_torque: 260 mNm, hold_torque: 90 mNm}
  bend: {no_load_speed: 0.8 rad/s, stall_torque: 0.9 Nm}
"""


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> MeasuredFile:
    """A bend of a robot whose motors are others than its profile says."""
    folder = tmp_path_factory.mktemp("twin")
    twin, recording = folder / "true.yaml", folder / "run.mcap"
    twin.write_text(TWIN)
    pirate_sm.run("mitre_bend", twin=str(twin), record=recording)
    return read_measured(recording)


@pytest.fixture(scope="module")
def numbers(measured: MeasuredFile) -> dict[tuple[str, str], RobotNumber]:
    return {(each.motor, each.key): each for each in robot_numbers([measured])}


@pytest.mark.thorough
@pytest.mark.parametrize("which", TRUE, ids=" ".join)
def test_a_number_of_the_true_robot_is_found_within_ten_percent(
    numbers: dict[tuple[str, str], RobotNumber], which: tuple[str, str]
) -> None:
    assert numbers[which].estimate.value == pytest.approx(TRUE[which], rel=0.1)


@pytest.mark.parametrize("which", TRUE, ids=" ".join)
def test_an_interval_holds_its_value_and_the_true_one(
    numbers: dict[tuple[str, str], RobotNumber], which: tuple[str, str]
) -> None:
    estimate = numbers[which].estimate
    assert estimate.low <= estimate.value <= estimate.high
    assert estimate.low <= TRUE[which] <= estimate.high


def test_friction_is_unknown_where_the_profile_does_not_derive_it(measured: MeasuredFile) -> None:
    columns = {
        name: values for name, values in measured.columns.items() if not name.startswith("mu_")
    }

    found = robot_numbers([measured._replace(columns=columns)])

    reasons = [each.estimate.reason for each in found if each.key.startswith("kinetic")]
    assert len(reasons) == 2
    assert all("derives no friction" in reason for reason in reasons)


def test_a_robot_that_never_moved_tells_why_nothing_is_known(measured: MeasuredFile) -> None:
    rest = {name: values[:40] for name, values in measured.columns.items()}

    found = robot_numbers([measured._replace(columns=rest, recording=None)])

    assert not any(each.estimate.known for each in found)
    assert all(each.estimate.reason for each in found)


def test_the_numbers_are_written_as_a_file_that_the_simulator_takes(
    measured: MeasuredFile, numbers: dict[tuple[str, str], RobotNumber], tmp_path: Path
) -> None:
    file = tmp_path / "found.yaml"
    assert measured.profile is not None
    file.write_text(twin_text(measured.profile, numbers.values(), "run.mcap"))

    twin = load_twin(file, measured.profile)

    assert twin.motors["wheel"].hold_torque == pytest.approx(0.09, rel=0.1)
    assert twin.motors["bend"].no_load_speed == pytest.approx(0.8, rel=0.1)
    assert "unknown: kinetic friction, front" in file.read_text()


def on_paper(measured: MeasuredFile, made: dict[str, np.ndarray]) -> MeasuredFile:
    """What was measured, with some columns of another kind, which no recording holds."""
    return measured._replace(columns={**measured.columns, **made}, recording=None)


def test_what_resists_rolling_is_taken_off_the_friction_that_the_engine_has_found(
    measured: MeasuredFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    resists = Estimate(0.02, 0.014, 0.026)
    monkeypatch.setattr(fitted, "rolling_resistance", lambda *_: resists)
    made = {
        f"mu_{number}": np.full(len(measured.columns["time_s"]), 0.22) for number in range(1, 7)
    }
    made |= {name.replace("mu", "wheel_torque"): -0.1 + 0 * each for name, each in made.items()}

    found = robot_numbers([on_paper(measured, made)])

    friction = [each.estimate.value for each in found if each.is_friction]
    assert friction == pytest.approx([0.2, 0.2])


def test_friction_is_the_median_where_wheels_slip_under_load(measured: MeasuredFile) -> None:
    count = len(measured.columns["time_s"])
    random = np.random.default_rng(1)
    made: dict[str, np.ndarray] = {}
    for number in range(1, 7):
        # A third of the time it turns in the air, where torque and friction are next to nothing.
        in_air = np.arange(count) % 3 == 0
        true = 0.2 if number <= 3 else 0.5
        made[f"mu_{number}"] = np.where(in_air, 0.01, true * random.normal(1, 0.03, count))
        made[f"wheel_torque_{number}"] = np.where(in_air, 0.002, -0.1)

    found = robot_numbers([on_paper(measured, made)])

    friction = {each.key: each.estimate for each in found if each.is_friction}
    assert friction["kinetic friction, front"].value == pytest.approx(0.2, rel=0.05)
    assert friction["kinetic friction, rear"].value == pytest.approx(0.5, rel=0.05)


def test_friction_that_was_found_is_written_with_static_friction_in_the_profiles_ratio(
    measured: MeasuredFile, tmp_path: Path
) -> None:
    assert measured.profile is not None
    parts = [RobotNumber("", f"kinetic friction, {n}", "", Estimate(n / 10)) for n in (2, 4)]
    file = tmp_path / "found.yaml"
    file.write_text(twin_text(measured.profile, parts, "run.mcap"))

    friction = load_twin(file, measured.profile).friction

    assert friction is not None
    assert (friction.static, friction.kinetic) == (0.42, 0.3)


def test_the_interval_of_friction_holds_the_error_of_the_normal_forces(
    measured: MeasuredFile,
) -> None:
    """Chain statics may be 5 % off in all frames of a run, which no draw of frames can show."""
    count = len(measured.columns["time_s"])
    made = {f"mu_{n}": np.full(count, 0.3) for n in range(1, 7)}
    torques = {f"wheel_torque_{n}": np.full(count, 0.1) for n in range(1, 7)}

    found = robot_numbers([on_paper(measured, made | torques)])

    (front, _) = (each.estimate for each in found if each.is_friction)
    assert (front.low, front.high) == pytest.approx((0.3 * 0.95, 0.3 * 1.05))


NO_LOAD, STALL = 4.0, 0.3


def turning(load: np.ndarray, rate_noise: float, load_noise: float, *, signed: bool) -> Intervals:
    """Readings of a motor at duty 0.7, as many as there are loads."""
    random = np.random.default_rng(3)
    rate = NO_LOAD * (0.7 - load / STALL) + random.normal(0, rate_noise, len(load))
    read = load + random.normal(0, load_noise, (2, len(load)))
    read = read if signed else np.abs(read)
    duty = np.full(len(load), 0.7)
    return Intervals(duty, rate, read.mean(axis=0), read[1] - read[0])


def test_readings_near_the_stall_do_not_make_a_motor_stronger() -> None:
    """Of rates that are as small as their errors only the larger ones pass a threshold."""
    load = np.concatenate([np.linspace(0.0, 0.2, 200), np.full(4000, 0.205)])
    it = turning(load, rate_noise=0.1, load_noise=0.001, signed=True)

    rows = driven(it)

    assert np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0] == pytest.approx(
        (NO_LOAD, NO_LOAD / STALL), rel=0.01
    )


def test_a_current_without_a_sign_does_not_make_a_motor_faster() -> None:
    load = np.concatenate([np.zeros(2000), np.linspace(0.05, 0.15, 500)])
    it = turning(load, rate_noise=0.01, load_noise=0.004, signed=False)

    speed, stall, _ = (each.estimate for each in wheel_numbers("wheel", driven(it), it))

    assert speed.value == pytest.approx(NO_LOAD, rel=0.002)
    assert stall.value == pytest.approx(STALL, rel=0.005)
    assert speed.low <= NO_LOAD <= speed.high
    assert stall.low <= STALL <= stall.high


FAST = """
format: 1
robot: pirate_ii
motors:
  wheel: {no_load_speed: 8.5 rad/s, stall_torque: 340 mNm, hold_torque: 50 mNm}
  bend: {no_load_speed: 0.8 rad/s, stall_torque: 1.2 Nm}
friction: {static: 0.3, kinetic: 0.23}
"""
SLIPS = """\
format: 1
mission: slips
robot: pirate_ii
pipe: straight_113
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: [robot.stuck, wheel.dead, clamp.lost, grip.exhausted], then: continue}]
start: slip
phases:
  slip:
    do:
      - {control: probing}
      - DriveForward
      - wait: [{after: 8 s}]
      - {command: Brake, on_failure: continue}
      - {control: none}
      - DriveBackward
      - wait: [{after: 3 s}]
    go: done
ends: {done: {succeed: Slipped}}
"""


@pytest.mark.thorough
def test_friction_is_found_by_the_motors_that_are_found(tmp_path: Path) -> None:
    """A profile whose wheels are a quarter too slow makes the engine's own estimate too small."""
    twin, mission, recording = (tmp_path / name for name in ("t.yaml", "m.yaml", "r.mcap"))
    twin.write_text(FAST)
    mission.write_text(SLIPS)
    pirate_sm.run(str(mission), twin=str(twin), ruler=True, record=recording, check=False)
    measured = read_measured(recording)

    found = {each.key: each.estimate for each in robot_numbers([measured])}
    as_assumed = {
        each.key: each.estimate for each in robot_numbers([measured._replace(recording=None)])
    }

    assert found["kinetic friction, front"].value == pytest.approx(0.23, rel=0.05)
    assert as_assumed["kinetic friction, front"].value < 0.9 * 0.23


def test_the_file_has_a_sample_of_robots_around_the_one(
    measured: MeasuredFile, numbers: dict[tuple[str, str], RobotNumber], tmp_path: Path
) -> None:
    file = tmp_path / "found.yaml"
    assert measured.profile is not None
    file.write_text(twin_text(measured.profile, numbers.values(), "run.mcap"))

    sample = load_twin(file, measured.profile).sample

    assert sample is not None
    assert len(sample.robots) == 64
    assert set(sample.assumed) == {"friction static", "friction kinetic"}
    columns = dict(zip(sample.numbers, np.array(sample.robots).T, strict=True))
    for (motor, key), true in TRUE.items():
        estimate = numbers[motor, key].estimate
        column = columns[f"{motor} {key}"]
        assert 0.5 * (estimate.high - estimate.low) < np.ptp(column), key
        assert estimate.low * 0.97 < column.min() < true * 1.02, key
        assert true * 0.98 < column.max() < estimate.high * 1.03, key
    assert all(columns["friction static"] >= columns["friction kinetic"])


def test_numbers_of_one_motor_are_drawn_together(
    numbers: dict[tuple[str, str], RobotNumber],
) -> None:
    """A speed without load that is found too large goes with a stall torque that is too small."""
    speed, stall = (
        numbers["bend", key].estimate.draws for key in ("no_load_speed", "stall_torque")
    )

    assert np.corrcoef(speed, stall)[0, 1] < -0.3


@pytest.mark.parametrize(
    ("hold_nm", "static", "kinetic"), [(0.0, 0.7, 0.5), (0.3, 0.0, 0.0), (0.3, 1.4, 1.0)]
)
def test_a_sample_of_what_a_profile_assumes_can_be_loaded(
    measured: MeasuredFile, tmp_path: Path, hold_nm: float, static: float, kinetic: float
) -> None:
    profile = measured.profile
    assert profile is not None
    wheel = profile.motors["wheel"].model_copy(update={"hold_torque": hold_nm})
    friction = {"static": static, "kinetic": kinetic}
    friction_ = profile.simulation.friction.model_copy(update=friction)
    simulation = profile.simulation.model_copy(update={"friction": friction_})
    motors = {**profile.motors, "wheel": wheel}
    changed = profile.model_copy(update={"motors": motors, "simulation": simulation})
    unknown = [RobotNumber("wheel", "hold_torque", "Nm", Estimate(reason="it stood"))]
    file = tmp_path / "found.yaml"

    file.write_text(twin_text(changed, unknown, "run.mcap"))

    sample = load_twin(file, profile).sample
    assert sample is not None
    assert len(sample.numbers) == (3 if hold_nm and kinetic else 1 if hold_nm else 2)


def test_a_robot_of_which_nothing_is_possible_has_no_sample(measured: MeasuredFile) -> None:
    assert measured.profile is not None
    none = [RobotNumber("wheel", "hold_torque", "Nm", Estimate(-1.0))]

    assert "sample:" not in twin_text(measured.profile, none, "run.mcap")


def test_the_methods_error_of_holding_is_not_that_of_the_stall() -> None:
    """Both are as wide as what their method does wrong, which is not the same thing."""
    load = np.tile(np.concatenate([np.zeros(200), np.linspace(0.05, 0.15, 20)]), 50)
    it = turning(load, rate_noise=0.01, load_noise=0.003, signed=False)
    borne = np.tile(np.linspace(0.05, 0.15, 40), 50)
    still = Intervals(0 * borne, np.ones(len(borne)), borne, 0 * borne)
    both = Intervals(*(np.concatenate(pair) for pair in zip(it, still, strict=True)))

    _, stall, hold = (each.estimate for each in wheel_numbers("wheel", driven(it), both))

    assert stall.known
    assert hold.known
    assert abs(np.corrcoef(hold.draws, stall.draws)[0, 1]) < 0.4


def test_the_clamp_threshold_is_what_standing_joints_nearly_always_bear() -> None:
    share = np.linspace(0.6, 1.0, 101)
    duty = np.full_like(share, 0.7)
    rate = np.where(np.arange(101) % 2, 0.0, 0.5)
    standing = Intervals(duty, rate, share * duty * 2.0, np.zeros_like(share))

    found = clamp_threshold(standing, Estimate(2.0, 1.9, 2.1))

    assert found.value == pytest.approx(0.624, abs=0.005)
    assert found.low < 0.6
    assert found.high > 0.63
    none = Intervals(duty, rate + 0.5, standing.load, standing.change)
    assert "no joint stood" in clamp_threshold(none, Estimate(2.0, 1.9, 2.1)).reason
    assert "unknown" in clamp_threshold(standing, Estimate()).reason


def test_rolling_resistance_is_the_mean_of_both_ways_and_no_noise_of_currents() -> None:
    way = np.repeat([1.0, -1.0], 50)
    torques = np.tile([0.029, 0.031], 50) + 0.01 * way  # it leans, and gravity helps one way

    found = rolling_resistance(np.column_stack([torques, torques, way]))

    assert found.value == pytest.approx(0.030, abs=0.001)
    assert (found.low, found.high) == pytest.approx((0.021, 0.039), rel=0.05)
    noise = rolling_resistance(np.column_stack([torques, 0 * torques, way]))
    assert not noise.known
    assert "at most 0.03" in noise.reason
    assert "both ways" in rolling_resistance(np.column_stack([torques, torques, way])[:50]).reason
    assert "both ways" in rolling_resistance(np.empty((0, 3))).reason


@pytest.mark.thorough
def test_a_robot_that_drives_both_ways_shows_its_rolling_resistance(
    tmp_path: Path, back_and_forth: Path
) -> None:
    twin, run = tmp_path / "true.yaml", tmp_path / "run.mcap"
    twin.write_text("format: 1\nrobot: pirate_ii\ntyre: {rolling_resistance: 0.03}\n")
    pirate_sm.run(str(back_and_forth), twin=str(twin), record=run, set={"each_way": "4 s"})
    measured = read_measured(run)
    assert measured.profile is not None

    numbers = robot_numbers([measured])

    found = next(each.estimate for each in numbers if each.key == "rolling resistance")
    assert found.low < 0.03 < found.high
    file = tmp_path / "twin.yaml"
    file.write_text(twin_text(measured.profile, numbers, run.name))
    drawn = load_twin(file, measured.profile, 3)
    assert drawn.tyre is not None
    assert 0.015 < drawn.tyre.rolling_resistance < 0.045
    assert "spin_radius" not in drawn.tyre.model_dump(exclude_unset=True)


@pytest.mark.thorough
def test_another_stream_draws_other_stretches_for_every_number(measured: MeasuredFile) -> None:
    first, second = robot_numbers([measured]), robot_numbers([measured], 1000)

    for one, other in zip(first, second, strict=True):
        assert one.estimate.value == pytest.approx(other.estimate.value, nan_ok=True)
        if one.estimate.known and not one.key.startswith("clamp threshold"):
            assert not np.array_equal(one.estimate.draws, other.estimate.draws)


def test_draws_of_two_streams_are_independent() -> None:
    rows = np.random.default_rng(3).normal(size=(400, 1))
    draws = [
        estimate_of(rows, lambda some: float(np.mean(some)), stream=stream).draws
        for stream in (0, 0, 1000)
    ]

    common = np.corrcoef(draws)
    assert common[0, 1] == pytest.approx(1)
    assert abs(common[0, 2]) < 0.2

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pirate_sm
from pirate_sm.core import library
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.lab.fitting import advice
from pirate_sm.lab.fitting.advice import advise, gained
from pirate_sm.lab.fitting.measurements import DRAWS, Estimate, read_measured
from pirate_sm.lab.fitting.prediction import SEEDS_FROM
from pirate_sm.lab.fitting.robot_numbers import RobotNumber, robot_numbers

UNKNOWN = Estimate(reason="it hardly moved")
CLAMP = """
format: 1
mission: {name}
robot: pirate_ii
{pipe}
start: clamp
phases: {{clamp: {{do: [ClampFront], go: done}}}}
ends: {{done: {{succeed: Clamped}}}}
"""
PIPE = "pipe: {diameter: 113 mm, segments: [{straight: 2 m}], start: {at: 1 m}}"


def known(value: float, share: float, seed: int) -> Estimate:
    """A value whose draws have this standard deviation, as a share of it."""
    off = np.random.default_rng(seed).normal(size=DRAWS)
    return Estimate(value, draws=value * (1 + share * (off - off.mean()) / off.std()))


def numbers(stall: Estimate, speed: Estimate) -> list[RobotNumber]:
    return [RobotNumber("bend", "stall_torque", "Nm", stall),
            RobotNumber("bend", "no_load_speed", "rad/s", speed)]  # fmt: skip


@pytest.fixture(scope="module")
def profile():
    return pirate_sm.load("mitre_bend").loaded_robot.profile


def test_an_assumed_number_gains_most(profile) -> None:
    before = numbers(known(1.0, 0.1, 1), UNKNOWN)

    bits, narrower = gained(profile, before, numbers(UNKNOWN, known(1.0, 0.1, 2)))

    assert narrower["bend stall_torque"] == 0
    assert narrower["bend no_load_speed"] == pytest.approx(0.875, abs=0.01)  # 0.8 to 0.1
    assert bits == pytest.approx(3.0, abs=0.1)


def test_a_second_recording_as_good_narrows_by_one_over_root_two(profile) -> None:
    before = numbers(known(1.0, 0.2, 1), UNKNOWN)

    bits, narrower = gained(profile, before, numbers(known(1.1, 0.2, 2), UNKNOWN))

    assert narrower["bend stall_torque"] == pytest.approx(0.29, abs=0.04)
    assert bits == pytest.approx(0.5, abs=0.1)


def test_errors_of_the_method_do_not_average_out(profile) -> None:
    before = numbers(known(1.0, 0.1, 1), UNKNOWN)

    bits, narrower = gained(profile, before, numbers(known(1.2, 0.1, 1), UNKNOWN))

    assert narrower["bend stall_torque"] == pytest.approx(0, abs=1e-6)
    assert bits == pytest.approx(0, abs=1e-6)


def test_a_bound_narrows_an_assumed_number_and_no_news_gains_nothing(profile) -> None:
    before = numbers(UNKNOWN, UNKNOWN)

    bits, narrower = gained(profile, before, numbers(Estimate(low=0.9, reason="at least"), UNKNOWN))

    assert 0.3 < narrower["bend stall_torque"] < 0.6
    assert bits > 0.5
    assert gained(profile, before, before)[0] == 0
    assert gained(profile, before, [])[0] == 0


@pytest.mark.thorough
def test_missions_are_simulated_and_those_that_cannot_run_left_out(tmp_path: Path) -> None:
    missions = [tmp_path / f"{name}.yaml" for name in ("clamps", "nowhere")]
    for mission, pipe in zip(missions, (PIPE, ""), strict=True):
        mission.write_text(CLAMP.format(name=mission.stem, pipe=pipe))
    pirate_sm.run(str(missions[0]), record=tmp_path / "run.mcap")
    measured = read_measured(tmp_path / "run.mcap")

    advised = advise([measured], missions, 2, 1, lambda share: None)

    (found,), left_out = advised.missions, advised.left_out
    assert (advised.robots, advised.unchecked) == (2, "")
    assert (found.mission, found.robots, found.succeeded) == ("clamps", 2, 2)
    assert found.narrower["bend no_load_speed"].mean >= 0
    assert {f"{each.motor} {each.key}" for each in robot_numbers([measured]) if each.motor} <= {
        *found.narrower
    }
    assert "pipe" in left_out["nowhere"]
    with pytest.raises(UsageError, match=r"no two robots can run a mission: .*pipe"):
        advise([measured], missions[1:], 2, 1, lambda share: None)


def test_missions_that_not_all_robots_pass_come_last() -> None:
    def advised(mission: str, bits: float, succeeded: int, robots: int) -> advice.MissionAdvice:
        return advice.MissionAdvice(mission, advice.MeanGain(bits, 0), {}, 1.0, succeeded, robots)

    found = [advised("none passes", 9.0, 0, 4), advised("little", 0.5, 4, 4),
             advised("three", 3.0, 3, 3), advised("much", 2.0, 4, 4)]  # fmt: skip

    ordered = [each.mission for each in advice.in_order(found, 4)]

    assert ordered == ["much", "little", "none passes", "three"]


def test_robots_that_end_the_recorded_mission_differently_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission, failing = tmp_path / "clamps.yaml", {0, 2, 3}
    mission.write_text(CLAMP.format(name=mission.stem, pipe=PIPE))
    pirate_sm.run(str(mission), record=tmp_path / "run.mcap")
    measured = [read_measured(tmp_path / "run.mcap")]

    @contextmanager
    def again(path: Path, twin: Path, number: int, seeds_from: int) -> Iterator[Any]:
        assert seeds_from != SEEDS_FROM  # else the mission is advised by the runs that were chosen
        yield SimpleNamespace(outcome="failed" if number in failing else "succeeded"), None

    monkeypatch.setattr(advice, "in_processes", lambda job, numbers, *_: map(job, numbers))
    monkeypatch.setattr(advice, "simulated_again", again)

    def chosen(drawn: int, robots: int) -> tuple[list[int], int, str]:
        return advice._chosen(measured, tmp_path / "twin.yaml", drawn, robots, 1)

    assert chosen(16, 2) == ([1, 4], 3, "")
    assert chosen(5, 4) == ([1, 4], 3, "")
    with pytest.raises(UsageError, match=r"1 of 4 robots .* two are needed"):
        chosen(4, 2)
    measured.append(measured[0]._replace(recording=tmp_path / "stopped.mcap"))
    ended = {"run.mcap": "succeeded", "stopped.mcap": "interrupted"}
    monkeypatch.setattr(advice, "read", lambda path: SimpleNamespace(outcome=ended[path.name]))
    assert chosen(16, 2) == ([1, 4], 3, "the recorded mission was stopped or ended in a fault")
    monkeypatch.setattr(advice, "simulated_again", lambda *_: raise_(PirateError("no pipe\nhere")))
    ended["stopped.mcap"] = "failed"
    assert chosen(16, 2) == ([0, 1], 0, "no pipe")


def raise_(error: Exception) -> Any:
    raise error


def test_missions_are_run_by_the_robot_that_was_recorded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission, radii = tmp_path / "clamps.yaml", []
    mission.write_text(CLAMP.format(name=mission.stem, pipe=PIPE))
    robot = tmp_path / "wider"
    shutil.copytree(library.find_robot("pirate_ii"), robot)
    profile = (robot / "profile.yaml").read_text()
    (robot / "profile.yaml").write_text(profile.replace("radius: 24 mm", "radius: 26 mm"))
    pirate_sm.run(str(mission), robot=robot, record=tmp_path / "run.mcap")

    def seen(loaded: LoadedMission, *_: object) -> None:
        radii.append(loaded.loaded_robot.profile.body.wheel_radius)
        raise PirateError("was seen\nand more")

    monkeypatch.setattr(advice, "in_processes", lambda job, numbers, *_: map(job, numbers))
    monkeypatch.setattr(advice, "simulated", seen)
    monkeypatch.setattr(advice, "_chosen", lambda *_: ([0, 1], 0, ""))
    with pytest.raises(UsageError, match=r"no two robots can run a mission: was seen$"):
        advise([read_measured(tmp_path / "run.mcap")], [mission], 2, 1, lambda share: None)
    assert radii == pytest.approx([0.026] * 2)

"""Forces and friction against the truth of the simulator, and out of a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isnan
from pathlib import Path
from statistics import mean, median

import pytest

from pirate_sm import run as run_mission
from pirate_sm.core import library
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare

UPRIGHT = """\
format: 1
mission: upright
robot: pirate_ii
pipe: vertical
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: hold
phases:
  hold: {do: [{control: exp_3a}], wait: [{after: 2 s, go: up}]}
  up: {do: [DriveForward], wait: [{after: 4 s, go: turn}]}
  turn: {do: [Brake], wait: [{after: 1 s, go: down}]}
  down: {do: [DriveBackward], wait: [{after: 4 s, go: stop}]}
  stop: {do: [Brake], go: done}
ends: {done: {succeed: Done}}
"""
WHEELS = range(1, 7)


@dataclass
class Course:
    """A run of a mission; every 100 ms its signals and the true press of each wheel."""

    samples: list[tuple[float, dict[str, float], list[float]]] = field(default_factory=list)

    def run(self, mission: Path, seed: int = 1) -> Course:
        prepared = prepare(Order(str(mission), seed=seed, ruler=True))
        run = MissionRun(
            prepared.engine,
            prepared.backend,
            observers=[self],
            companions=(*prepared.companions, FirstChoice()),
        )
        self._look = lambda: (
            dict(prepared.engine.signals(run.state)) if run.state else {},
            list(prepared.backend.robot.values("press")),
        )
        assert run.execute().ended.outcome == "succeeded"
        return self

    def see(self, effects: object, now_s: float) -> None:
        if not self.samples or now_s >= self.samples[-1][0] + 0.1:
            self.samples.append((now_s, *self._look()))

    def where(self, wanted: Callable[[dict[str, float]], bool]) -> list[tuple]:
        return [(s, press) for _, s, press in self.samples if s and wanted(s)]


def errors(samples: list[tuple]) -> list[float]:
    """By how much each wheel's normal force is wrong in the mean, as a share."""
    return [
        mean(s[f"normal_force_{wheel}"] for s, _ in samples)
        / mean(press[wheel - 1] for _, press in samples)
        - 1
        for wheel in WHEELS
    ]


@pytest.fixture(scope="module")
def upright(tmp_path_factory: pytest.TempPathFactory) -> list[Course]:
    path = tmp_path_factory.mktemp("upright") / "upright.yaml"
    path.write_text(UPRIGHT, encoding="utf-8")
    return [Course().run(path, seed) for seed in range(1, 9)]


@pytest.fixture(scope="module")
def blocked(tmp_path_factory: pytest.TempPathFactory) -> Course:
    return Course().run(slippery(tmp_path_factory.mktemp("blocked")))


def slippery(folder: Path) -> Path:
    """Experiment 1a in a pipe of little friction."""
    for name in ("exp_1a_both", "exp_1_round"):
        text = library.find_mission(name).read_text("utf-8")
        block = "  blockages:\n"
        text = text.replace(block, f"  friction: {{static: 0.3, kinetic: 0.2}}\n{block}")
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    pipes = library.find_pipe("straight_113").parent
    (folder / "pipes").symlink_to(pipes)
    return folder / "exp_1a_both.yaml"


@pytest.mark.thorough
@pytest.mark.parametrize("way", [1, -1], ids=["up", "down"])
def test_forces_driving_upright_are_within_6_percent_and_their_mean_4(upright, way):
    samples = [each.where(lambda s: way * s["body_speed"] > 0.08)[5:] for each in upright]

    assert min(map(len, samples)) > 20
    # The noise of one run moves the force of a wheel by up to 2 %: here eight runs count as one.
    shares = [mean(each) for each in zip(*map(errors, samples), strict=True)]
    assert max(map(abs, shares)) < 0.06
    assert abs(mean(shares)) < 0.04


def test_blocked_forces_and_the_friction_of_the_slipping_wheel_are_right_within_5_percent(blocked):
    samples = blocked.where(lambda s: not isnan(s["mu_6"]) and abs(s["body_speed"]) < 0.005)

    assert len(samples) > 3
    assert max(map(abs, errors(samples))) < 0.05
    assert median(s["mu_6"] for s, _ in samples) == pytest.approx(0.2, rel=0.05)


@pytest.mark.thorough
def test_wheels_that_do_not_slip_show_no_friction(upright):
    shown = lambda s: any(not isnan(s[f"mu_{wheel}"]) for wheel in WHEELS)  # noqa: E731

    assert [each.where(shown) for each in upright] == [[]] * len(upright)


@pytest.mark.thorough
def test_such_a_run_replays_exactly(tmp_path):
    mission, file = tmp_path / "upright.yaml", tmp_path / "run.mcap"
    mission.write_text(UPRIGHT, encoding="utf-8")
    assert run_mission(str(mission), seed=1, ruler=True, record=file).outcome == "succeeded"

    recording = read_recording(file)
    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None

"""One robot in an upright pipe: what it does under a control, over a line that may lose frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import isnan, nan
from pathlib import Path
from random import Random
from shutil import copytree
from statistics import median
from typing import TYPE_CHECKING

from pirate_sm.core import library
from pirate_sm.core._engine.robot.loops import RunningTorqueLoop
from pirate_sm.core.effects import Effect, Fault
from pirate_sm.core.events import BuiltInFault

if TYPE_CHECKING:
    from pirate_sm.core.loading import LoadedMission
    from pirate_sm.core.robot import RobotSpec
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.simulation.simulated_robot import SimulatedRobot

MISSION = Path(__file__).with_name("upright.yaml")
KINETIC, TOO_LITTLE = (0.2, 0.7), (0.06, 0.12)
"""Ranges of kinetic friction: that of pipes, and one that asks for more than the clamps may."""

STATIC_SHARE = 1.3
PATCH_M = 0.2
PATCH_BEGINS_M = 0.7, 1.7
FALLEN_M = 0.050
SAMPLE_EVERY_S = 0.1
STAND_S = 3.0
SETTLED_S = 3.0
"""Clamps that start at their torques of rest have wound up after this time."""

FIXED = """\
  fixed:
    description: As exp_3a, clamped by 280 mNm
    extends: exp_3a
    actuation:
      BendingState:
        DoubleClamped: {bend_1: -280 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 280 mNm}
"""


@dataclass
class Watch:
    """Notes what the robot does, from the truth and from what the engine knows.

    Attributes:
        down: 1 where ahead is downhill, else -1.
        spec: What the engine knows of the robot.
        robot: The robot as it truly is.
        slid_m: How far it has been carried downhill, beyond what any of its wheels rolled.
        dragged_m: How far beyond what the median of its wheels rolled, at most.
        exhausted_m: How far it had slid when a grip first became exhausted; NaN before.
        torques_nm: By whether the friction of the part is known, what its apex bears.
    """

    down: int
    spec: RobotSpec
    robot: SimulatedRobot
    run: MissionRun | None = None
    due_s: float = 0.0
    slid_m: float = 0.0
    dragged_m: float = 0.0
    exhausted_m: float = nan
    torques_nm: dict[bool, list[float]] = field(default_factory=lambda: {False: [], True: []})
    _last: tuple[float, ...] = ()
    _ahead_m: float = 0.0

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Take a sample where one is due."""
        exhausted = BuiltInFault.GRIP_EXHAUSTED.code
        if any(isinstance(each, Fault) and each.code == exhausted for each in effects):
            self._look()
            self.exhausted_m = self.slid_m if isnan(self.exhausted_m) else self.exhausted_m
        if now_s < self.due_s or self.run is None or self.run.state is None:
            return
        self.due_s = now_s + SAMPLE_EVERY_S
        self._look()
        state = self.run.state
        for loop in state.robot.loops:
            if isinstance(loop, RunningTorqueLoop) and loop.asked_nm and now_s > SETTLED_S:
                known = loop.gripping is not None and not isnan(loop.gripping.friction)
                self.torques_nm[known].append(abs(state.sensing.numbers[loop.spec.torque]))

    def stand(self) -> None:
        """Look on for a while after the end, when nothing controls it any more."""
        turn, robot = self.robot.turns(one_value=False)[0], self.robot
        until_s = robot.moved_until_s + STAND_S
        while robot.moved_until_s < until_s:
            robot.step(robot.moved_until_s, turn)
        self._look()

    def _look(self) -> None:
        """Compare how far it has come downhill with what its wheels have rolled."""
        arcs_m, angles = self.robot.arcs_m, self.robot.values("wheel")
        rolled = [angles[wheel.place] * wheel.metres_per_rad for wheel in self.spec.wheels]
        now = tuple(self.down * each for each in (sum(arcs_m) / len(arcs_m), *rolled))
        if self._last:
            steps_m = [to - was for to, was in zip(now, self._last, strict=True)]
            came_m, rolls_m = steps_m[0], steps_m[1:]
            self.slid_m += max(0.0, came_m - max(rolls_m))
            self._ahead_m += came_m - median(rolls_m)
            self.dragged_m = max(self.dragged_m, self._ahead_m)
        self._last = now


@dataclass(frozen=True)
class Trial:
    """One run: ``unknown_nm`` and ``known_nm`` are what the clamps bore, by what was known."""

    seed: int
    kinetic: float
    heads_down: bool
    ended: str
    slid_m: float
    dragged_m: float
    exhausted_m: float
    unknown_nm: tuple[float, ...]
    known_nm: tuple[float, ...]

    @property
    def fell(self) -> bool:
        """Return whether the robot was carried away."""
        return self.slid_m > FALLEN_M


def written(folder: Path, control: str) -> Path:
    """Write the mission with this control, and the robot that has it; return its path."""
    robot = folder / "pirate_ii"
    if not robot.exists():
        copytree(library.find_robot("pirate_ii"), robot)
        profile = robot / "profile.yaml"
        text = profile.read_text("utf-8")
        profile.write_text(text.replace("  exp_3b:\n", f"{FIXED}  exp_3b:\n", 1), "utf-8")
    text = MISSION.read_text("utf-8")
    if control == "fixed":
        text = text.replace("control: careful", "control: fixed").replace(
            "{control: probing}, ", ""
        )
    path = folder / f"{control}.yaml"
    text = text.replace("robot: pirate_ii", f"robot: {robot}")
    path.write_text(text.replace("mission: upright", f"mission: {control}"), "utf-8")
    return path


@cache
def _loaded(mission: str) -> LoadedMission:
    from pirate_sm.running.wiring import Order, load

    return load(Order(mission))


def try_out(
    mission: str, loss: float | None, seed: int, kinetic: tuple[float, float] = KINETIC
) -> Trial:
    """Run the mission with the friction and the heading of this seed.

    Args:
        mission: Path of the mission.
        loss: Share of all frames that the line to the emulated bay loses, each way; None: the
            simulator without a line.
        seed: Also of all noise.
        kinetic: The range of the kinetic friction.
    """
    heads_down = bool(seed % 2)
    friction = Random(f"friction {seed}").uniform(*kinetic)
    loaded = _in_the_pipe(_loaded(mission), seed, friction, heads_down)
    down = 1 if heads_down else -1
    if loss is None:
        watch, run = _in_the_simulator(loaded, mission, seed, down)
    else:
        watch, run = _over_the_line(loaded, loss, seed, down)
    watch.run = run
    ended = run.execute().ended
    watch.stand()
    torques = watch.torques_nm
    return Trial(
        seed,
        friction,
        heads_down,
        f"{ended.outcome}: {ended.message}",
        watch.slid_m,
        watch.dragged_m,
        watch.exhausted_m,
        tuple(torques[False]),
        tuple(torques[True]),
    )


def _in_the_pipe(
    loaded: LoadedMission, seed: int, kinetic: float, heads_down: bool
) -> LoadedMission:
    """Return the mission in a pipe with this friction, and half of it on a patch."""
    from pirate_sm.core._model.pipe_runs import Patch
    from pirate_sm.core.models import Friction

    begins_m = Random(f"patch {seed}").uniform(*PATCH_BEGINS_M)
    patch = Patch.model_validate(
        {
            "from": f"{begins_m} m",
            "to": f"{begins_m + PATCH_M} m",
            "static": STATIC_SHARE * kinetic / 2,
            "kinetic": kinetic / 2,
        }
    )
    changes = {
        "patches": (patch,),
        "friction": Friction(static=STATIC_SHARE * kinetic, kinetic=kinetic),
        "uphill": 3.141592653589793 if heads_down else 0.0,
    }
    assert loaded.pipe is not None
    return replace(loaded, pipe=loaded.pipe.model_copy(update=changes))


def _in_the_simulator(
    loaded: LoadedMission, mission: str, seed: int, down: int
) -> tuple[Watch, MissionRun]:
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.running.runtime.scripted_events import FirstChoice
    from pirate_sm.running.wiring import Order, prepare

    prepared = prepare(Order(mission, seed=seed, ruler=True), loaded)
    watch = Watch(down, loaded.robot, prepared.backend.robot)  # type: ignore[attr-defined]
    companions = (*prepared.companions, FirstChoice())
    return watch, MissionRun(
        prepared.engine, prepared.backend, observers=[watch], companions=companions
    )


def _over_the_line(
    loaded: LoadedMission, loss: float, seed: int, down: int
) -> tuple[Watch, MissionRun]:
    from benchmarks.arrays import bay_at
    from pirate_sm.core.engine import Engine
    from pirate_sm.robot.backends.serial.backend import SerialBackend
    from pirate_sm.robot.detectors.simple_detectors import Ruler
    from pirate_sm.running.runtime.backend_links import Holder
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.running.runtime.scripted_events import FirstChoice
    from pirate_sm.simulation.bay.bay_defects import Switches
    from pirate_sm.simulation.bay.virtual import VirtualPort

    bay, plan = bay_at(loaded, seed, Switches(loss, loss))
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    settings = loaded.loaded_robot.profile.simulation.ruler
    assert settings is not None
    ruler = Ruler(settings, lambda: (bay.robot.moved_until_s, bay.robot.arcs_m), seed)
    watch = Watch(down, loaded.robot, bay.robot)
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    companions = (Holder(backend.hold), ruler, FirstChoice())
    return watch, MissionRun(engine, backend, observers=[watch], companions=companions)

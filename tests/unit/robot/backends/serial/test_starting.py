"""A start over the link: what is declared is held against what the boards of the bay say."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core import effects as fx
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

ROOT = Path(__file__).resolve().parents[5]
MISSION = """
format: 1
mission: declared
robot: pirate_ii
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: sensor.silent, then: continue}]
start: go
phases:
  go: {do: [RelaxRear, DriveForward, Brake], go: out}
ends: {out: {succeed: Out}}
"""


class Notes:
    """Keeps every effect."""

    def __init__(self) -> None:
        self.effects: list[Effect] = []

    def see(self, effects: list[Effect], now_s: float) -> None:
        self.effects += effects


def started(tmp_path: Path, *, clamped: bool) -> tuple[fx.Ended, list[Effect]]:
    """The mission, which names no pipe, on a robot that is clamped in the shipped one or lies."""
    file = tmp_path / "declared.yaml"
    file.write_text(MISSION, encoding="utf-8")
    loaded = load_mission(file)
    pipe = load_mission(ROOT / "sequences" / "mitre_bend.yaml").pipe
    assert pipe is not None
    folder, profile = loaded.loaded_robot.folder, loaded.loaded_robot.profile
    start = start_values(loaded) if clamped else None
    bay = VirtualBay(profile, pipe, message_texts(folder, profile), Switches(), 0, start)
    backend = SerialBackend(read_plan(folder, profile, loaded.robot), VirtualPort(bay))
    notes = Notes()
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    result = MissionRun(engine, backend, observers=[notes]).execute()
    return result.ended, notes.effects


def test_a_clamp_that_is_only_said_is_not_driven_with(tmp_path: Path) -> None:
    ended, effects = started(tmp_path, clamped=False)

    assert ended.outcome == "fault"
    assert ended.message.startswith("start.contradicted: ")
    assert "the rear part is declared to hold" in ended.message
    assert not [each for each in effects if isinstance(each, fx.CommandStatus | fx.Setpoints)]


def test_a_clamp_that_is_there_is_confirmed_and_driven_with(tmp_path: Path) -> None:
    ended, effects = started(tmp_path, clamped=True)

    assert ended.message == "Out"
    statuses = [(e.name, e.status) for e in effects if isinstance(e, fx.CommandStatus)]
    assert statuses[0] == ("RelaxRear", "sent")
    before = effects.index(next(e for e in effects if isinstance(e, fx.CommandStatus)))
    changes = [each for each in effects[:before] if isinstance(each, fx.StateChange)]
    assert changes[-1].unconfirmed == ("LightingState",)

"""Slip and friction of a recording, as a robot whose motors are others than assumed shows them.

The sign of a wheel's torque, and with it the normal forces, follow from the speed without load. A
profile that assumes it a fifth too small makes friction a fifth too small.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pirate_sm.core.events import SensorFrame
from pirate_sm.core.profile import Motor, Profile
from pirate_sm.core.sensing import TractionSpec, WheelTraction, with_traction
from pirate_sm.lab.fitting.columns import Columns
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.replay.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay.replay import rerun
from pirate_sm.running.recording.tables.table_rows import TIME


def signals_with(path: Path, motors: Mapping[str, Motor]) -> Columns | None:
    """Return the signals of a recording once in a round, with those of traction made anew.

    What the mission did stays as it was recorded.

    Args:
        path: The recording.
        motors: The robot's motors by their kind.

    Returns:
        The signals, or None if the robot derives none of traction.

    Raises:
        RecordingError: The recording cannot be read.
    """
    recording = read_recording(path)
    rows: list[tuple[float, ...]] = []
    with recorded_mission(recording.header) as loaded:
        spec = loaded.robot.traction
        if spec is None:
            return None
        robot, origin_s = loaded.robot, recording.origin_s
        motors_spec = _with_motors(spec, loaded.loaded_robot.profile, motors)
        slipping, after_gaps = None, {gap.step for gap in recording.gaps}
        for each in rerun(recording, loaded):
            state, event = each.state, each.step.event
            if each.step.number in after_gaps:
                slipping = None  # what the wheels did in it is unknown
            if state is None or not isinstance(event, SensorFrame):
                continue
            if robot.boards[event.board].position != motors_spec.board:
                continue
            sensing, body = state.sensing, state.robot
            if slipping is not None:
                sensing = sensing._replace(traction=sensing.traction._replace(slipping=slipping))
            at, around, now_s = body.configuration, state.surveyed.reported, each.at_s + origin_s
            anew = with_traction(robot, motors_spec, sensing, body.values, at, around, now_s)
            slipping = anew.traction.slipping
            rows.append((each.at_s, *anew.numbers[: len(robot.vocabulary.numbers)]))
    names = (TIME, *robot.vocabulary.numbers)
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return dict(zip(names, values.T, strict=True))


def _with_motors(spec: TractionSpec, profile: Profile, motors: Mapping[str, Motor]) -> TractionSpec:
    """Return the traction of a robot that reckons with these motors."""

    def changed(wheel: WheelTraction) -> WheelTraction:
        motor = motors[profile.slots[wheel.slot].motor]
        stall, no_load = motor.stall_torque, motor.no_load_speed
        return wheel._replace(
            stall_nm=stall or wheel.stall_nm, no_load_rad_s=no_load or wheel.no_load_rad_s
        )

    return spec._replace(wheels=tuple(map(changed, spec.wheels)))

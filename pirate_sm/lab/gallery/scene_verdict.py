"""Judge a step of a scene: what came of it beside what its file says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pirate_sm.core.campaign import Expected, TrueEnd
from pirate_sm.core.effects import Setpoints
from pirate_sm.core.errors import PirateError
from pirate_sm.core.simulation import SIMULATORS
from pirate_sm.lab.campaign.verdict import judge
from pirate_sm.lab.campaign.watched_run import watched_run
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.replay.recorded_mission import recorded_mission, recorded_robot
from pirate_sm.running.wiring.resumed_run import recorded_order, with_folder
from pirate_sm.views.report.run_list import ListedRun, listed

_WITH_TRUTH = SIMULATORS | {"bay"}
"""Backends that know how the robot truly stands, and do the same again with the same seed."""


def unmet(expected: Expected, exit_code: int, output: str, recording: Path | None) -> list[str]:
    """Return what is not as expected, in sentences; nothing if all is.

    Args:
        expected: What the scene's file says.
        exit_code: The exit code of the step.
        output: What a command said that records nothing.
        recording: The recording of a run.
    """
    found = []
    if exit_code != expected.exit:
        found.append(f"exit code {exit_code}, expected {expected.exit}")
    if recording is None:
        if expected.says not in output:
            found.append(f"it does not say '{expected.says}'")
        return found
    try:
        read = read_recording(recording)
        found += [*_differences(expected, listed(read, "")), *_still_driven(read)]
        return [*found, *_not_held(expected, read)]
    except PirateError as error:
        return [*found, str(error)]


def _differences(expected: Expected, run: ListedRun) -> Iterator[str]:
    if expected.ended is not None and run.outcome != expected.ended:
        yield f"it ended {run.outcome}: {run.message}; expected {expected.ended}"
    if expected.says not in run.message:
        yield f"its end says '{run.message}', expected '{expected.says}'"
    for code in expected.faults:
        if code not in run.faults:
            yield f"the fault {code} was not reported, but {', '.join(run.faults) or 'none'}"


def _still_driven(recording: Recording) -> Iterator[str]:
    """Yield which motors the last setpoints drive that stand in the safe state."""
    robot, last = recorded_robot(recording.header), None
    for step in recording.steps():
        for effect in step.effects:
            if isinstance(effect, Setpoints):
                last = effect
    driven = [slot for slot in robot.safe_zero if last is not None and last.values[slot]]
    if driven:
        names = ", ".join(robot.slots[slot].name for slot in driven)
        yield f"it did not end in the safe state: {names} driven"


def _not_held(expected: Expected, recording: Recording) -> Iterator[str]:
    """Yield what is wrong with the robot's hold at the end, by the simulator's truth.

    A recording has no torques that a silent robot does not report, so the run is repeated with its
    seed. Runs that were resumed cannot be repeated alone, and those with a camera take too long.
    """
    header = recording.header
    with_camera = header.detector.partition(":")[0] == "vision"
    if header.resumed or with_camera or header.backend not in _WITH_TRUTH:
        return
    order = replace(recorded_order(header), backend=header.backend, check=False, panel=None)
    with recorded_mission(header) as loaded:
        outcome = watched_run(order, with_folder(loaded, header))
    ended = listed(recording, "").message
    if outcome.message != ended:
        yield f"repeated with its seed it ends otherwise: {outcome.message}"
        return
    verdict = judge(outcome, TrueEnd())
    if verdict.held != expected.held:
        slid = f"{outcome.slid_m * 1000:.0f} mm in two seconds"
        yield f"in truth it is {'held' if verdict.held else f'not held, and carried on by {slid}'}"
    if verdict.unsafe:
        yield f"in truth it does not end in the safe state: {verdict.unsafe}"

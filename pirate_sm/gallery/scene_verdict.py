"""Judge a step of a scene: what came of it beside what its file says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pirate_sm.errors import RecordingError
from pirate_sm.model.effects import Setpoints
from pirate_sm.model.scene import Expected
from pirate_sm.recording.read.reader import Recording, read_recording
from pirate_sm.recording.replay.recorded_mission import recorded_robot
from pirate_sm.report.run_list import ListedRun, listed


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
        return [*found, *_differences(expected, listed(read, "")), *_still_driven(read)]
    except RecordingError as error:
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

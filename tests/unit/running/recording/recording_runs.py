"""Runs missions in process and keeps them, for whoever reads recordings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from resumes import Resumes

from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.core.effects import Ended
from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Asked, detecting
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.recording.format.header import header_of
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.running.wiring.run_recorder import Kept, RunRecorder, run_header
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

ROOT = Path(__file__).resolve().parents[4]

_PACED = 1e6
"""A speed at which nothing waits, but at which messages for viewers are recorded."""


def spoilt_in(recording: Recording, path: Path, *places: int) -> Recording:
    """The recording with a wrong bit in each of these pieces."""
    data = bytearray(recording.path.read_bytes())
    for place in places:
        hit = recording.content.pieces[place]
        data[hit.at + hit.size // 2] ^= 1
    path.write_bytes(data)
    return read_recording(path, damaged=True)


def record(path: Path, order: Order) -> Recording:
    """The run has been made and kept in the file."""
    prepared = prepare(order)
    header = header_of(
        prepared.loaded,
        began=datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC),
        backend=prepared.backend.name,
        nominal=prepared.engine.nominal,
        detector=prepared.detector,
        options={"start_phase": order.start_phase, "states": order.states, "seed": order.seed},
    )
    recorder = Recorder(RecordingFile(DiskFile(path), header), header, real_time=False)
    companions = [*prepared.companions]
    if not prepared.attended:
        companions.append(FirstChoice("a test"))
    if order.breakpoints:
        companions.append(Resumes())
    run = MissionRun(
        prepared.engine,
        prepared.backend,
        companions=companions,
        tap=recorder,
        breakpoints=prepared.breakpoints,
    )
    recorder.follow(lambda: run.state)
    run.execute()
    recorder.close()
    assert not recorder.failure
    return read_recording(path)


def record_with_viewers(path: Path, order: Order) -> Kept:
    """Run the mission with a recording as the command line makes it, messages for viewers too."""
    return record_as_asked(path, order, _PACED)


def record_as_asked(
    path: Path,
    order: Order,
    factor: float,
    camera: Callable[[], CameraView | None] | None = None,
) -> Kept:
    """Run the mission at this speed with a recording as the command line makes it."""
    prepared = prepare(order)
    prepared = replace(prepared, detecting=prepared.detecting._replace(camera=camera))
    with recorded(prepared, RecordingOptions(record=str(path)), factor) as kept:
        companions = [*prepared.companions, *kept.companions, FirstChoice()]
        run = MissionRun(
            prepared.engine, prepared.backend, tap=kept.tap, companions=companions, factor=factor
        )
        kept.follow(run)
        run.execute()
    return kept


def record_serial(path: Path, mission: str, switches: Switches, seed: int = 0) -> Recording:
    """The mission has been run against the emulated bay in virtual time and kept in the file."""
    loaded = load_mission(ROOT / "sequences" / f"{mission}.yaml")
    profile, robot = loaded.loaded_robot.profile, loaded.robot
    assert profile.serial is not None
    assert loaded.pipe is not None
    folder = loaded.loaded_robot.folder
    start = start_values(loaded)
    bay = VirtualBay(
        profile,
        loaded.pipe,
        message_texts(folder, profile),
        switches,
        seed,
        start,
    )
    backend = SerialBackend(read_plan(folder, profile, robot), VirtualPort(bay))
    engine = Engine(robot, loaded.program, nominal=False)
    says = detecting(None, "odometry", Asked(profile, robot, loaded.pipe))
    header = header_of(
        loaded,
        began=datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC),
        backend=backend.name,
        nominal=False,
        detector=says.kind,
        options={},
    )
    recorder = Recorder(RecordingFile(DiskFile(path), header), header, real_time=False)
    companions = [*says.companions, FirstChoice("a test")]
    run = MissionRun(engine, backend, companions=companions, tap=recorder)
    recorder.follow(lambda: run.state)
    run.execute()
    recorder.close()
    return read_recording(path)


class _Memory:
    """A file in memory."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: bytes, /) -> None:
        self.data += data

    def close(self) -> None:
        pass


def beginning_of(order: Order) -> int:
    """Return how large a file of this run is before anything has happened, bytes."""
    prepared = prepare(order)
    header = run_header(prepared, inf, datetime.now(UTC))
    memory = _Memory()
    RecordingFile(memory, header)
    return len(memory.data)


def record_cut_off(
    path: Path, order: Order, until_s: float, each_s: float = inf, *, fails: bool = False
) -> None:
    """Run the mission until then, and keep what a file would hold if everything stopped there.

    A piece of the file is written each time that ``each_s`` have passed. A program that ``fails``
    then abandons the run before.
    """
    prepared = prepare(order)
    header = run_header(prepared, inf, datetime.now(UTC))
    memory = _Memory()
    kept = RunRecorder(prepared, header, RecordingFile(memory, header))
    companions = (*prepared.companions, FirstChoice("a test"))
    pump = Pump(prepared.engine, prepared.backend, companions=companions, tap=kept.recorder)
    kept.follow(prepared, lambda: pump.state)
    pump.start()
    kept.recorder.ahead_s, written_s = 60.0, 0.0
    while pump.now_s < until_s and pump.ended is None:
        pump.take(*pump.wait(until_s))
        if pump.now_s >= written_s + each_s:
            kept.recorder.secure()
            written_s = pump.now_s
    if fails:
        pump.abandon(Ended("fault", "the program has failed"))
    kept.recorder.close()
    whole = bytes(memory.data)
    path.write_bytes(whole[: read_end(whole)])


def read_end(data: bytes) -> int:
    """Return where the pieces of a finished recording end: before its end and its index."""
    at = len(MCAP0_MAGIC)
    while data[at] != Opcode.DATA_END:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return at

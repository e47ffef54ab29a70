"""Runs missions in process and keeps them, for whoever reads recordings."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from pirate_sm.recording.file import DiskFile, RecordingFile
from pirate_sm.recording.header import header_of
from pirate_sm.recording.reader import Recording, read_recording
from pirate_sm.recording.recorder import Recorder
from pirate_sm.runtime.companions import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.wiring import Order, prepare

ROOT = Path(__file__).resolve().parents[3]


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
    recorder = Recorder(RecordingFile(DiskFile(path), header), header, patient=True)
    companions = [*prepared.companions]
    if not prepared.attended:
        companions.append(FirstChoice("a test"))
    run = MissionRun(prepared.engine, prepared.backend, companions=companions, tap=recorder)
    run.execute()
    recorder.close()
    assert not recorder.failure
    return read_recording(path)

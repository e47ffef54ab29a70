"""Write a recording of many hours that was cut off, as a run in real time would have left it."""

from __future__ import annotations

from datetime import UTC, datetime
from math import inf
from pathlib import Path

from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.run_recorder import RunRecorder, run_header

_WRITTEN_EVERY_S = 0.25
_HOUR_S = 3600.0


def write_long_recording(path: Path, hours: float) -> None:
    """Write the recording: a clamped robot that waits, in pieces of a quarter of a second."""
    mission = path.with_suffix(".yaml")
    mission.write_text(
        "format: 1\nmission: long\nrobot: pirate_ii\npipe: mitre_90\nstart: hold\n"
        "time_limit: 900 h\nphases:\n  hold:\n    do: [ClampFront]\n"
        "    wait: [{operator: enough, go: done}]\n"
        f"    within: {{time: {hours + 1:g} h, go: done}}\n"
        "ends: {done: {succeed: It has waited}}\n"
    )
    prepared = prepare(Order(str(mission)))
    header = run_header(prepared, inf, datetime.now(UTC))
    kept = RunRecorder(prepared, header, RecordingFile(path.open("xb", buffering=0), header))
    tap = kept.recorder
    pump = Pump(
        prepared.engine, prepared.backend, companions=(*prepared.companions, FirstChoice()), tap=tap
    )
    kept.follow(prepared, lambda: pump.state)
    pump.start()
    written_s = 0.0
    while pump.now_s < hours * _HOUR_S:
        until_s = written_s + _WRITTEN_EVERY_S
        pump.glide(until_s)
        pump.take(*pump.wait(until_s))
        if pump.now_s >= until_s:
            written_s = until_s
            tap.secure()
    tap.close()

"""Runs a mission, records it, and writes down beside it when each step was; somebody kills this.

    python crashing.py RECORDING WITNESS SPEED

WITNESS gets 16 bytes a step, its number and the moment of the machine's clock when it was told.
"""

from __future__ import annotations

import os
import struct
import sys
import time
from pathlib import Path
from typing import Any

from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare

STEP = struct.Struct("<qd")


class Witness:
    """A tap that hands everything on to a recorder and remembers when."""

    def __init__(self, tap: Any, path: str) -> None:
        self._tap = tap
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT)
        self._steps = 0

    def start(self, seen: Any, *arguments: Any) -> None:
        self._tap.start(seen, *arguments)
        for _ in range(len(seen) + 1):
            self._remember()

    def take(self, *arguments: Any) -> None:
        self._tap.take(*arguments)
        self._remember()

    @property
    def stepwise(self) -> bool:
        return True  # so that each step is told

    def abandon(self, *arguments: Any) -> None:
        self._tap.abandon(*arguments)

    def _remember(self) -> None:
        os.write(self._file, STEP.pack(self._steps, time.monotonic()))
        self._steps += 1


def main() -> None:
    recording, witness, speed = sys.argv[1:]
    prepared = prepare(Order("mitre_bend"))
    with recorded(prepared, RecordingOptions(record=recording), float(speed)) as kept:
        companions = [*prepared.companions, *kept.companions, FirstChoice()]
        run = MissionRun(
            prepared.engine, prepared.backend, companions=companions,
            tap=Witness(kept.tap, witness), factor=float(speed),
        )  # fmt: skip
        kept.follow(run)
        print("begun", flush=True)
        run.execute()


def witnessed(path: Path) -> list[tuple[int, float]]:
    """Number and moment of each step that was told."""
    data = path.read_bytes()
    return list(STEP.iter_unpack(data[: len(data) // STEP.size * STEP.size]))


if __name__ == "__main__":
    main()

"""A bay behind a pseudo-terminal, as `pirate bay` is one, that writes down its truth.

    python -m benchmarks.witness MISSION LINK [--no-dead-man]

The truth stands in a file beside the link. SIGUSR1 pulls the cable out for a moment, SIGUSR2
for longer than anybody waits. The bay goes on meanwhile, and so does its file.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from itertools import chain
from math import inf
from pathlib import Path
from typing import NamedTuple

CABLE_OUT_S = 1.0
CABLE_OUT_LONG_S = 12.0
"""Longer than a runner waits for the shipped robot: 8 s."""

NO_DEAD_MAN = "--no-dead-man"
"""The firmware has no dead man's switch, whatever the profile says; as for `pirate bay`."""

SAMPLE_EVERY_S = 0.02
_LAST_BYTES = 4096


class Sample(NamedTuple):
    """The bay at one moment: duties of motors, angles at the wheels' joints, places, torques."""

    at_s: float
    joints: tuple[float, ...]
    wheels: tuple[float, ...]
    bends_rad: tuple[float, ...]
    arcs_m: tuple[float, ...]
    torques_nm: tuple[float, ...]


def samples_of(link: Path) -> Iterator[Sample]:
    """What the bay at this link has written down, oldest first."""
    for line in _truth(link).read_text().splitlines():
        if line.endswith("]"):
            at_s, *rest = json.loads(line)
            yield Sample(at_s, *(tuple(each) for each in rest))


def driven_now(link: Path) -> bool:
    """Whether wheels are driven at the bay at this link."""
    return any(_last(link, "wheels"))


def _last(link: Path, field: str) -> list[float]:
    """Return this field of the last sample; empty before the first."""
    with _truth(link).open("rb") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - _LAST_BYTES))
        line = file.read().splitlines()[-2:-1]  # the last one may not be whole
    found: list[float] = json.loads(line[0])[Sample._fields.index(field)] if line else []
    return found


def main() -> int:
    """The bay has run in real time until it was asked to end."""
    from pirate_sm.core import library
    from pirate_sm.core.loading import load_mission
    from pirate_sm.simulation.bay.bay_defects import Switches
    from pirate_sm.simulation.bay.node_handle import message_texts
    from pirate_sm.simulation.bay.terminal import StopSignals, Terminal, serve
    from pirate_sm.simulation.bay.virtual import VirtualBay

    mission, link = sys.argv[1], Path(sys.argv[2])
    loaded = load_mission(library.find_mission(mission))
    profile = loaded.loaded_robot.profile
    assert loaded.pipe is not None
    assert profile.serial is not None
    texts = message_texts(loaded.loaded_robot.folder, profile)
    switches = Switches(dead_man=NO_DEAD_MAN not in sys.argv[3:])
    bay = VirtualBay(profile, loaded.pipe, texts, switches)
    began_s = time.monotonic()
    sampled_s, out_s = -inf, 0.0

    def pull(number: int, frame: object) -> None:
        nonlocal out_s
        out_s = CABLE_OUT_S if number == signal.SIGUSR1 else CABLE_OUT_LONG_S

    def sample() -> None:
        nonlocal sampled_s
        now = time.monotonic()
        if now >= sampled_s + SAMPLE_EVERY_S:
            sampled_s = now
            duties, truth = bay.duties, bay.truth
            joints = len(truth.bends_rad)
            driven = duties[:joints], duties[joints:]
            line = Sample(now, *driven, truth.bends_rad, truth.arcs_m, truth.torques_nm)
            out.write(json.dumps(line) + "\n")

    def stopped() -> bool:
        sample()
        return told.stop or out_s > 0.0

    signal.signal(signal.SIGUSR1, pull)
    signal.signal(signal.SIGUSR2, pull)
    with StopSignals() as told, _truth(link).open("w", buffering=1) as out:
        while not told.stop:
            with Terminal(link, profile.serial.baud) as terminal:
                print(terminal.name, flush=True)
                moments = chain([began_s], iter(time.monotonic, None))
                serve(bay, terminal, stopped, clock=lambda: next(moments))  # noqa: B023
            bay.close(time.monotonic() - began_s)
            back_s = time.monotonic() + out_s
            while time.monotonic() < back_s:
                bay.advance(time.monotonic() - began_s)
                sample()
                time.sleep(SAMPLE_EVERY_S)
            out_s = 0.0
    return 0


def _truth(link: Path) -> Path:
    return link.with_suffix(".truth")


if __name__ == "__main__":
    sys.exit(main())

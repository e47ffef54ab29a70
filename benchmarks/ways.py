"""How many files of the package a sensor frame passes on its way, and a step of a mission on its.

    python -m benchmarks.ways [MISSION]

The mission runs over the driver of the serial link and the emulated bay, in virtual time. Counted
are the files in which a function is called while the first frame that fires a trigger is read from
the port and taken, and while the first command is given and its array is written to the port; those
of the simulated robot at the other end are not. The mission is loaded before.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pirate_sm.core.effects import Effect

ROOT = Path(__file__).resolve().parents[1] / "pirate_sm"


class Followed:
    """An observer that keeps the files passed until an effect of the kind is reported.

    Args:
        kind: The class of the effect with which the way ends.
    """

    def __init__(self, kind: type[Effect]) -> None:
        self._kind = kind
        self._passed: set[str] = set()
        self.way: set[str] = set()

    def call(self, frame: FrameType, event: str, _: object) -> None:
        """Note the file of a function that is called; each wait for the backend begins a way."""
        name = frame.f_code.co_filename
        if event != "call" or self.way or not name.startswith(str(ROOT)):
            return
        if frame.f_code.co_name == "wait" and name.endswith("pump.py"):
            self._passed.clear()
        self._passed.add(str(Path(name).relative_to(ROOT)))

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Keep the way if it has come to its end."""
        if not self.way and any(isinstance(each, self._kind) for each in effects):
            self.way = {name for name in self._passed if not name.startswith("simulation/")}


def followed(mission: str, kind: type[Effect]) -> list[str]:
    """Return the files that are passed until the first effect of this kind."""
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.running.wiring import Order, prepare

    prepared = prepare(Order(mission, backend="bay"))
    follower = Followed(kind)
    run = MissionRun(
        prepared.engine, prepared.backend, observers=[follower], companions=prepared.companions
    )
    sys.setprofile(follower.call)
    try:
        run.execute()
    finally:
        sys.setprofile(None)
    return sorted(follower.way)


def main() -> int:
    """Both ways are followed and printed."""
    from pirate_sm.core.effects import Setpoints, TriggerFired

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("mission", nargs="?", metavar="MISSION", default="mitre_bend")
    mission = parser.parse_args().mission
    for what, kind in (
        ("a frame, from the port to the trigger that it fires", TriggerFired),
        ("a command, from the mission's step to the port", Setpoints),
    ):
        way = followed(mission, kind)
        print(f"{what}: {len(way)} files")
        for name in way:
            print(f"    {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

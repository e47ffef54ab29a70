"""How soon the stop of a control panel acts.

    python -m benchmarks.panel [--stops 20]

A panel is played behind a pseudo-terminal. The stop is timed from before its bytes are written
until the safe array is handed to the backend, in the console (as :mod:`benchmarks.console` times
the stop key) and in a run as ``pirate-run`` makes it, at moments spread over the bend mission in
real time. Under load the console's own loop is kept busy and so is every core but one; a run has
every core against it.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import pty
import random
import sys
import tty
from collections.abc import Callable
from statistics import median
from threading import Thread
from time import perf_counter

from benchmarks.console import (
    SIZE,
    SLICE_S,
    Timed,
    begun_session,
    busy,
    drive,
    spin,
    switching_often,
    wait,
)
from pirate_sm.core.errors import ExitCode
from pirate_sm.robot.control_panel.panel_reader import PanelCompanion
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.check_process import CheckProcess

STOPS = 20
LATEST_S = 6.0
"""A run is stopped within this time of its beginning."""


class Played:
    """A panel whose buttons this program presses."""

    def __init__(self) -> None:
        self._far, near = pty.openpty()
        tty.setraw(near)
        self.name = f"nanokontrol2:{os.ttyname(near)}"

    def press(self, number: int) -> float:
        """The button is pressed and released; returns the time before."""
        began_s = perf_counter()
        os.write(self._far, bytes([0xB0, number, 127, number, 0]))
        return began_s


def main() -> int:
    """Both are measured and printed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--stops", type=int, default=STOPS, help="of each kind")
    stops = parser.parse_args().stops
    print(f"stop on a panel, simulator in real time, {os.cpu_count()} cores")
    played = Played()
    with switching_often():
        for loaded in (False, True):
            found = asyncio.run(_in_console(played, stops, loaded=loaded))
            _tell("in the console", loaded, found)
    for loaded in (False, True):
        _tell("in a run", loaded, _in_runs(played, stops, loaded=loaded))
    return 0


def _tell(where: str, loaded: bool, found: list[float]) -> None:
    name = f"{where}{', under load' if loaded else ''}"
    print(
        f"    {name:26} {median(found) * 1e3:6.1f} ms to the safe array, "
        f"most {max(found) * 1e3:.1f} ms of {len(found)}",
        flush=True,
    )


async def _in_console(played: Played, stops: int, *, loaded: bool) -> list[float]:
    session, timed = begun_session(played.name)
    panel = session.prepared.panel
    assert panel is not None
    found = []
    with CheckProcess() as process, panel.reader(lambda reason: session.stop()) as reader:
        app = Console(session, reader, ask_check=process.ask)
        async with app.run_test(size=SIZE):
            await asyncio.sleep(1.0)
            for number in range(stops):
                with busy(loaded):
                    await drive(session)
                    pressed: list[float] = []
                    press = _later(played, panel.panel.controls["STOP"], 0.05, pressed)
                    spin(SLICE_S) if loaded else await asyncio.sleep(SLICE_S)
                    press.join()
                assert timed.submitted_s > pressed[0], f"stop {number} did nothing"
                found.append(timed.submitted_s - pressed[0])
        session.quit()
        session.join()
    return found


def _in_runs(played: Played, stops: int, *, loaded: bool) -> list[float]:
    chance = random.Random(14)
    with busy(loaded, os.cpu_count() or 2):
        return [_in_run(played, chance.uniform(1.0, LATEST_S)) for _ in range(stops)]


def _in_run(played: Played, after_s: float) -> float:
    requests = StopRequests()
    order = Order("mitre_bend", panel=played.name)
    prepared = prepare(order, load(order))
    timed = TimedStop(prepared.backend, lambda: requests.stop is not None)
    panel = prepared.panel
    assert panel is not None
    pressed: list[float] = []
    with panel.reader(lambda reason: requests.ask(Stop(reason, ExitCode.INTERRUPTED))) as reader:
        robot = prepared.loaded.robot
        beside = PanelCompanion(reader, robot, speaks="sim", valid_for_s=1.0, keyboard=False)
        run = MissionRun(
            prepared.engine,
            timed,
            companions=[*prepared.companions, beside],
            requests=requests,
            factor=1.0,
        )
        press = _later(played, panel.panel.controls["STOP"], after_s, pressed)
        result = run.execute()
        press.join()
    assert result.ended.message == "stopped on the panel"
    assert timed.stopped_s > pressed[0]
    return timed.stopped_s - pressed[0]


def _later(played: Played, number: int, after_s: float, pressed: list[float]) -> Thread:
    """A thread that presses the button after this time, and notes when."""

    def press() -> None:
        wait(after_s)
        pressed.append(played.press(number))

    thread = Thread(target=press)
    thread.start()
    return thread


class TimedStop(Timed):
    """A backend that notes the first array after a request to stop."""

    def __init__(self, backend: object, stopped: Callable[[], bool]) -> None:
        super().__init__(backend)
        self._stopped = stopped
        self.stopped_s = 0.0

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """It is noted."""
        super().submit(setpoint_id, values)
        if self._stopped() and not self.stopped_s:
            self.stopped_s = self.submitted_s


if __name__ == "__main__":
    sys.exit(main())

"""How fast the console draws, and how soon its stop acts.

    python -m benchmarks.console [--seconds 10] [--stops 20]

A mission runs in the simulator in real time, at 160 × 48 characters, all panels visible. Frames
are drawings of the robot that were put on the (headless) terminal. The stop is timed from the
moment at which the thread that reads the terminal has the key until the safe array is handed to
the backend; under load, the console's own loop is kept busy and so is every core but one.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from statistics import median
from threading import Event, Thread
from time import perf_counter
from typing import Any

from textual.events import Key

from pirate_sm.cli.commands.console import SWITCH_EVERY_S
from pirate_sm.core.events import OperatorCommand
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.check_process import CheckProcess
from pirate_sm.views.console.session import OperatorSession
from pirate_sm.views.console.terminal_driver import StopDriver
from pirate_sm.views.console.widgets import PipePicture

SIZE = (160, 48)
WATCHED_S = 10.0
STOPS = 20
SLICE_S = 0.4


def main() -> int:
    """Both are measured and printed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=WATCHED_S, help="how long it is watched")
    parser.add_argument(
        "--stops", type=int, default=STOPS, help="without load, and as many under it"
    )
    wishes = parser.parse_args()
    measure_console(wishes.seconds, wishes.stops)
    return 0


def measure_console(seconds: float = WATCHED_S, stops: int = STOPS) -> None:
    """Both are measured and printed."""
    frames = asyncio.run(_frames(seconds))
    with switching_often():
        idle = asyncio.run(_stops(stops, loaded=False))
        loaded = asyncio.run(_stops(stops, loaded=True))
    columns, rows = SIZE
    print(f"console, {columns} × {rows}, simulator in real time, {os.cpu_count()} cores")
    print(f"    frames drawn     {frames:6.1f} /s over {seconds:g} s of the bend mission")
    for name, found in (("", idle), (", under load", loaded)):
        print(
            f"    stop{name:13} {median(found) * 1e3:6.1f} ms to the safe array, "
            f"most {max(found) * 1e3:.1f} ms of {len(found)}"
        )


@contextmanager
def switching_often() -> Iterator[None]:
    """Threads take turns as often as `pirate console` lets them."""
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_EVERY_S)
    try:
        yield
    finally:
        sys.setswitchinterval(usual_s)


class Timed:
    """A backend that notes when an array was handed to it."""

    def __init__(self, backend: Any) -> None:
        self._backend = backend
        self.submitted_s = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._backend, name)

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """It is noted."""
        self.submitted_s = perf_counter()
        self._backend.submit(setpoint_id, values)


def begun_session(panel: str | None = None) -> tuple[OperatorSession, Timed]:
    """A session of the bend mission, perhaps with a panel, and its backend."""
    order = Order("mitre_bend", panel=panel)
    prepared = prepare(order, load(order))
    timed = Timed(prepared.backend)
    return OperatorSession(replace(prepared, backend=timed)), timed


async def _frames(seconds: float) -> float:
    session, _ = begun_session()
    app = Console(session)
    async with app.run_test(size=SIZE) as pilot:
        await asyncio.sleep(1.0)
        await pilot.press("R")
        await asyncio.sleep(1.0)
        picture = app.query_one(PipePicture)
        began, before = perf_counter(), picture.frames
        await asyncio.sleep(seconds)
        rate = (picture.frames - before) / (perf_counter() - began)
    session.quit()
    session.join()
    return rate


async def _stops(stops: int, *, loaded: bool) -> list[float]:
    session, timed = begun_session()
    found = []
    with CheckProcess() as process:
        app = Console(session, ask_check=process.ask)
        async with app.run_test(size=SIZE):
            await asyncio.sleep(1.0)
            for number in range(stops):
                with busy(loaded):
                    await drive(session)
                    driver = StopDriver(app)
                    pressed: list[float] = []

                    def press(driver: StopDriver = driver, pressed: list[float] = pressed) -> None:
                        wait(0.05)
                        pressed.append(perf_counter())
                        driver.process_message(Key("space", " "))

                    thread = Thread(target=press)
                    thread.start()
                    spin(SLICE_S) if loaded else await asyncio.sleep(SLICE_S)
                    thread.join()
                assert timed.submitted_s > pressed[0], f"stop {number} did nothing"
                found.append(timed.submitted_s - pressed[0])
    session.quit()
    session.join()
    return found


async def drive(session: OperatorSession) -> None:
    """The wheels turn."""
    for command in ("ClampFront", "ClampRear", "DriveForward"):
        session.give_event(OperatorCommand(command))
        for _ in range(400):
            await asyncio.sleep(0.025)
            state = session.latest.state
            if state is not None and state.robot.motion is None and state.robot.flight is None:
                break


@contextmanager
def busy(wanted: bool, cores: int = max((os.cpu_count() or 2) - 1, 1)) -> Iterator[None]:
    """So many cores, by default all but one, have something else to do."""
    count = cores if wanted else 0
    burn = [sys.executable, "-c", "while True: sum(range(10_000))"]
    others = [subprocess.Popen(burn) for _ in range(count)]
    try:
        yield
    finally:
        for each in others:
            each.kill()
            each.wait()


def spin(seconds: float) -> None:
    """The console's own loop is busy for this long."""
    until = perf_counter() + seconds
    while perf_counter() < until:
        sum(range(1_000))


def wait(seconds: float) -> None:
    """So much of the wall's time passes."""
    Event().wait(seconds)


if __name__ == "__main__":
    sys.exit(main())

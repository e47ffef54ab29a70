"""How soon a stop from the page of a run acts, and how smoothly the page moves, with many viewers.

    python -m benchmarks.page [--stops 20] [--viewers 5]

Runs of the bend mission in real time, as ``pirate-run --page`` makes them. The viewers are pages in
Chromium, in a process of their own. A stop is timed from before its request is sent over HTTP until
the safe array is handed to the backend, at moments spread over the run; and from when the process
of the run hears of it, which is what the run itself takes. A frame counts where the time that a
page shows has moved on.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from multiprocessing import get_context
from multiprocessing.connection import Connection
from statistics import median
from tempfile import TemporaryDirectory
from threading import Thread
from time import perf_counter, sleep
from urllib.parse import urlsplit

from benchmarks.panel import TimedStop
from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.core.errors import ExitCode
from pirate_sm.robot.control_panel.panel_reader import PanelCompanion
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.views.report.page_process import PageProcess

STOPS, VIEWERS = 20, 5
EARLIEST_S, LATEST_S = 2.0, 5.0
"""A run is stopped between these times after all viewers have its page."""

_COUNT = """() => {
  let moved = false;
  window.counted = 0;
  new MutationObserver(() => { moved = true; })
    .observe(document.getElementById('clock'), { childList: true });
  const frame = () => {
    window.counted += moved;
    moved = false;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}"""


def main() -> int:
    """Both are measured and printed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--stops", type=int, default=STOPS)
    parser.add_argument("--viewers", type=int, default=VIEWERS)
    options = parser.parse_args()
    load_before = os.getloadavg()[0]
    print(
        f"the page of a run in real time, {options.viewers} viewers, {os.cpu_count()} cores, "
        f"load before {load_before:.1f}",
        flush=True,
    )
    chance = random.Random(42)
    measured = [
        _stopped(chance.uniform(EARLIEST_S, LATEST_S), options.viewers)
        for _ in range(options.stops)
    ]
    whole, own = [each[0] for each in measured], [each[1] for each in measured]
    frames = [rate for each in measured for rate in each[2]]
    _tell("from the request of a viewer to the safe array", whole)
    _tell("from the process of the run to the safe array", own)
    print(f"    frames a second: median {median(frames):.1f}, least {min(frames):.1f}")
    return 0


def _tell(what: str, found: list[float]) -> None:
    print(
        f"    {what:48} median {median(found) * 1e3:5.1f} ms, "
        f"most {max(found) * 1e3:5.1f} ms of {len(found)}"
    )


def _stopped(after_s: float, viewers: int) -> tuple[float, float, list[float]]:
    """Returns both times to the safe array, and the frames a second of each viewer."""
    requests, heard = StopRequests(), [0.0]

    def end_run(reason: str) -> None:
        heard[0] = perf_counter()
        requests.ask(Stop(reason, ExitCode.INTERRUPTED))

    order = Order("mitre_bend")
    prepared = prepare(order, load(order))
    timed = TimedStop(prepared.backend, lambda: requests.stop is not None)
    sent, frames = [0.0], list[float]()
    with TemporaryDirectory() as folder, PageProcess((), end_run) as page:
        options = RecordingOptions(f"{folder}/run.mcap", page=page)
        with recorded(prepared, options, 1.0) as kept, _watched(page.address, viewers) as rates:
            robot = prepared.loaded.robot
            beside = PanelCompanion(page, robot, speaks="sim", valid_for_s=1.0, keyboard=True)
            run = MissionRun(
                prepared.engine,
                timed,
                companions=[*prepared.companions, *kept.companions, beside],
                tap=kept.tap,
                requests=requests,
                factor=1.0,
                paused=True,
            )
            kept.follow(run)
            stopping = Thread(target=_stop_later, args=(page.address, after_s, rates, sent, frames))
            stopping.start()
            result = run.execute()
            stopping.join()
    assert result.ended.message == "stopped on the page", result
    return timed.stopped_s - sent[0], timed.stopped_s - heard[0], frames


def _stop_later(
    address: str,
    after_s: float,
    rates: Callable[[float], list[float]],
    sent: list[float],
    frames: list[float],
) -> None:
    """Begins the mission when all viewers have its page, and asks for a stop later."""
    rates(0.0)
    _press(address, "continue")
    frames.extend(rates(after_s))
    sent[0] = _press(address, "stop")


def _press(address: str, button: str) -> float:
    """Presses a button, over a connection that is open, as that of a browser is.

    Returns:
        When the request was sent.
    """
    where = urlsplit(address)
    connection = HTTPConnection(str(where.hostname), where.port)
    connection.connect()
    headers = {"Origin": f"http://{where.netloc}", "Authorization": f"Bearer {where.fragment}"}
    sent_s = perf_counter()
    connection.request("POST", "/presses", button, headers)
    assert connection.getresponse().status == 204
    connection.close()
    return sent_s


@contextmanager
def _watched(address: str, count: int) -> Iterator[Callable[[float], list[float]]]:
    """Yields what lets viewers watch for this time and returns their frames a second."""
    here, there = get_context("spawn").Pipe()
    process = get_context("spawn").Process(target=_view, args=(address, count, there))
    process.start()
    here.recv()

    def rates(for_s: float) -> list[float]:
        here.send(for_s)
        counted: list[float] = here.recv()
        return counted

    try:
        yield rates
    finally:
        here.send(None)
        process.join()


def _view(address: str, count: int, asked: Connection) -> None:
    """The viewers, in a process of their own."""
    from playwright.sync_api import sync_playwright

    found = os.environ.get("CHROMIUM", "/usr/bin/chromium")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found)
        pages = [browser.new_context().new_page() for _ in range(count)]
        asked.send("ready")
        for page in pages:
            page.goto(address.partition("#")[0])
            page.wait_for_selector("html[data-ready=yes]", state="attached", timeout=120_000)
        for page in pages:
            page.evaluate(_COUNT)
        while (for_s := asked.recv()) is not None:
            began_s = perf_counter()
            for page in pages:
                page.evaluate("window.counted = 0")
            sleep(for_s)
            took_s = perf_counter() - began_s
            asked.send([page.evaluate("window.counted") / took_s for page in pages])
        browser.close()


if __name__ == "__main__":
    sys.exit(main())

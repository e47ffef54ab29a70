"""The console on a serial link with everything wrong that the emulated bay knows."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from pirate_sm.core.events import OperatorCommand
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.session import OperatorSession
from pirate_sm.views.showing import alarms, panels

from .driving import by_hand

PIRATE = Path(sys.executable).with_name("pirate")

pytestmark = pytest.mark.slow  # real ports, in real time


@contextmanager
def on_a_bay(*options: str) -> Iterator[OperatorSession]:
    command = [str(PIRATE), "bay", "--pipe", "mitre_90", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as bay:
        assert bay.stdout is not None
        port = bay.stdout.readline().strip()
        session = OperatorSession(by_hand(Order("by_hand", "serial", port=port, pipe="mitre_90")))
        session.start()
        try:
            yield session
        finally:
            session.quit()
            assert session.join(20.0)
            os.kill(bay.pid, signal.SIGTERM)


def until(what: Callable[[], object], within_s: float) -> None:
    give_up_s = time.monotonic() + within_s
    while not what():
        assert time.monotonic() < give_up_s, "it has not come to be so"
        time.sleep(0.01)


def drive(session: OperatorSession) -> None:
    # Until it has been looked at, commands are refused.
    until(lambda: (state := session.latest.state) is not None and state.look is None, 20.0)
    for command in ("ClampFront", "ClampRear", "DriveForward"):
        session.give_event(OperatorCommand(command))
        name = f"{command} done"
        until(
            lambda name=name: any(name in each.line.text for each in session.latest.story.recent),
            15,
        )


def stopped(session: OperatorSession) -> bool:
    state, robot = session.latest.state, session.latest.scene.robot
    return (
        session.result is not None
        and session.result.ended.outcome == "interrupted"
        and state is not None
        and all(state.robot.values[slot] == 0 for slot in robot.safe_zero)
    )


def test_a_bad_line_is_shown_and_the_stop_works() -> None:
    with on_a_bay("--loss", "20%") as session:
        drive(session)
        words = "\n".join(str(each) for each in panels.link(session.latest))
        assert "lossy" in words
        session.stop()
        until(lambda: stopped(session), 3.0)


@pytest.mark.parametrize("options", [["--hang-at", "11", "--hang-for", "3"], ["--reset-at", "11"]])
def test_a_silence_is_told_within_a_second_and_the_stop_works_when_it_is_over(
    options: list[str],
) -> None:
    with on_a_bay(*options) as session:
        drive(session)
        until(lambda: session.latest.link and session.latest.link.trouble, 20.0)
        link = session.latest.link
        assert link is not None
        assert link.silent_s < 1.0
        said = " ".join(str(each) for each in alarms.bar(session.latest, (), 200))
        assert "no word for" in said
        assert "nothing comes from the robot" in said
        assert str(panels.header(session.latest, 80)).startswith(" ? ")
        session.stop()
        until(lambda: stopped(session), 10.0)


def test_the_checks_of_the_open_port_go_green_and_send_nothing() -> None:
    with on_a_bay() as session:
        until(lambda: session.latest.state is not None, 20.0)
        link, before = session.prepared.open_link, session.latest.link
        assert link is not None
        assert before is not None
        with link:
            until(lambda: link.found is not None and link.found.go, 20.0)
        assert session.latest.link is not None
        assert session.latest.link.written == before.written

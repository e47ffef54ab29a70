"""Ten tasks of an operator at the console, over a pseudo-terminal, next to the log of the bay."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pirate_sm.running.wiring import Order, load
from pirate_sm.views.console.availability import letters_for

from .operators_desk import PIRATE, ROBOT, Bay, Cable, Desk, wheels_sent

pytestmark = pytest.mark.slow  # real terminals, in real time

SIZES = [(80, 24), (120, 36), (160, 48)]
LETTERS = letters_for(
    [*load(Order("mitre_bend")).loaded_robot.profile.commands, *ROBOT.detector_words]
)


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def desk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Desk]:
    bay = Bay(tmp_path)
    cable = Cable(bay.port, tmp_path / "pirate")
    desk = Desk(tmp_path, request.param, bay, cable)
    try:
        yield desk
    finally:
        if desk.pid > 0:
            desk.end(signal.SIGKILL)
        cable.close()
        bay.close()


@pytest.mark.timeout(900)
def test_what_the_screen_says_in_ten_tasks_is_what_the_bay_has_done(desk: Desk) -> None:
    pre_flight(desk)
    drive(desk)
    stop(desk)
    pull_the_cable(desk)
    fail(desk)
    hand_back(desk)
    resume(desk)
    adopt(desk)
    observe(desk)

    assert desk.looks > 100


def pre_flight(desk: Desk) -> None:
    """The doctor finds nothing wrong, and moves nothing; so does the list of the console."""
    said_by(desk, "doctor", "--port", str(desk.cable.link), "--seconds", "2", "--plain")
    desk.bay.look()
    assert not any(desk.bay.in_force)
    connect(desk)
    desk.press("#")
    for name in ("topics", "boards", "sensors"):
        desk.until(f"✓ {name}", 20.0)
    assert not any(desk.bay.in_force)
    close(desk)


def said_by(desk: Desk, *command: str) -> str:
    """What another command says that succeeds."""
    said = subprocess.run(
        [sys.executable, "-c", PIRATE, *command],
        capture_output=True,
        text=True,
        check=False,
        cwd=desk.folder,
    )
    assert said.returncode == 0, said.stdout + said.stderr
    return said.stdout


def connect(desk: Desk) -> None:
    """The robot is shown as its sensors show it, and stands."""
    desk.open("mitre_bend")
    desk.until("PAUSED")
    desk.until(lambda: re.search(r"● FrontWheels +Free", desk.text))
    assert "┄" not in desk.text


def command(desk: Desk, name: str, shown: str) -> None:
    give(desk, name, lambda: re.search(shown, desk.text))


def give(desk: Desk, name: str, what: Callable[[], object]) -> None:
    """The command is given until it is shown that it is done.

    On a computer that stands still the guardian of the port stops what it did before.
    """
    for _ in range(4):
        if tried(desk, name, what):
            return
        desk.press("\x1b")
        desk.wait(2.0)
    raise AssertionError(f"{name} is not done:\n{desk.text}")


def tried(desk: Desk, name: str, what: Callable[[], object]) -> bool:
    """Whether the command is done before another line says that the computer stood still."""
    before = desk.text.count("runner.stalled")
    desk.press(LETTERS[name])
    agree(desk, lambda: what() or desk.text.count("runner.stalled") > before)
    return bool(what())


def agree(desk: Desk, what: Callable[[], object]) -> None:
    """It has come to be so; a question before is answered with yes."""
    desk.until(lambda: what() or "(y)" in desk.text)
    while "(y)" in desk.text:
        desk.wait(1.0)  # what is pressed before it can be read is no answer
        desk.press("y")
        desk.wait(0.5)
    desk.until(what, 40.0)


def drive(desk: Desk) -> None:
    """Clamped by hand, something is seen, and driven."""
    command(desk, "ClampFront", "● FrontWheels +Fixed")
    command(desk, "ClampRear", "● RearWheels +Fixed")
    desk.press("@")
    desk.until("Seen there")
    type_in(desk, "0.40 m")
    desk.press("\t")
    type_in(desk, "crack, 3 o'clock now")
    desk.press("\r")
    desk.until("wheel 1 at 0.40 m")
    page(desk, "motors")
    give(desk, "DriveForward", lambda: set(wheels_sent(desk.text)) == {"100 %", "-100 %"})
    desk.wait(0.5)  # the robot accepts it


def type_in(desk: Desk, text: str) -> None:
    """The text is typed again while the dialog ignores keys."""
    for _ in range(5):
        desk.wait(1.0)
        desk.press(text)
        desk.wait(1.0)
        if f"▊  {text} " in desk.text:
            return
        desk.press("\x15")  # empties the line
    raise AssertionError(f"{text} cannot be typed:\n{desk.text}")


def page(desk: Desk, name: str) -> None:
    """The page of the motors, or the first one, is shown."""
    headings = {"motors": "measured", "drive": "─Commands"}
    for _ in range(6):
        if headings[name] in desk.text:
            return
        before = shown_page(desk)
        desk.press("\t")
        desk.until(lambda before=before: shown_page(desk) != before, 5.0)
        desk.wait(0.5)
    raise AssertionError(f"there is no page {name}:\n{desk.text}")


def shown_page(desk: Desk) -> object:
    """What tells one page from another."""
    return re.findall(r"^ .*\[(Drive|Mission|Body|Log|Motors)\]", desk.text, re.MULTILINE), (
        "─Commands" in desk.text
    )


def stop(desk: Desk) -> None:
    """Everything says that the wheels were stopped: the header, the states, the setpoints."""
    desk.press(" ")
    desk.until(lambda: not desk.bay.drives, 2.0)
    desk.until("■ STOPPED, PAUSED", 10.0)
    assert set(wheels_sent(desk.text)) == {"0 %"}
    page(desk, "drive")
    desk.until("sent: 0")
    close(desk)


def close(desk: Desk) -> None:
    """Esc, until no dialog is open; what is pressed before one can be read is for nobody."""
    for _ in range(5):
        desk.press("\x1b")
        desk.wait(1.0)  # a terminal takes Esc and what follows at once for one key
        if "Esc leaves" not in desk.text:
            return
    raise AssertionError(f"it does not close:\n{desk.text}")


def pull_the_cable(desk: Desk) -> None:
    """While it drives: what is not known is a question, and the switch stops it."""
    command(desk, "DriveForward", "● RearWheels +DrivingForward")
    trips = desk.bay.trips
    desk.cable.pull()
    desk.until(lambda: desk.text.startswith(" ?"), 3.0)
    desk.until("switch has stopped", 5.0)
    assert desk.bay.trips > trips
    desk.wait(1.0)  # compared all the while
    desk.cable.plug()
    desk.until(lambda: not desk.text.startswith(" ?"), 20.0)
    desk.until("!: ", 10.0)  # an alarm is left to be seen


def fail(desk: Desk) -> None:
    """A controller that hangs for too long ends the run; the first cause can be read."""
    desk.bay.freeze()
    desk.until("no word for", 5.0)
    desk.until("link.silent", 30.0)
    desk.bay.thaw()
    desk.press("!")
    desk.until("Alarms, the newest first")
    desk.until("1st")
    close(desk)
    desk.until(lambda: re.search(r"● \w+ +(Fixed|DoubleClamped)", desk.text), 60.0)


def hand_back(desk: Desk) -> None:
    """The mission takes over where commands lead that the list names."""
    desk.press("h")
    desk.until(lambda: re.search("prepare +first ", desk.text), 60.0)
    for _ in range(20):
        if re.search("▸ prepare +first ", desk.text):
            break
        desk.press("\x1b[B")
        desk.wait(0.5)
    desk.press("\r")
    desk.until("(y)")
    agree(desk, lambda: "▶ RUNNING" in desk.text)


def resume(desk: Desk) -> None:
    """The console is killed while the mission runs, and another one continues with it."""
    desk.wait(2.0)  # what it has done is on the disk
    desk.end(signal.SIGKILL)
    (newest,) = sorted((desk.folder / "runs").glob("*.mcap"))[-1:]
    port = "--port", str(desk.cable.link)  # its name is that of no device
    desk.open(*port, "--resume", str(newest.relative_to(desk.folder)))
    desk.until("leave [enter]?", 60.0)
    desk.press("g\r")
    desk.until("PAUSED", 60.0)
    assert not desk.bay.drives
    desk.end()


def adopt(desk: Desk) -> None:
    """A robot that is clamped already is taken as its sensors show it."""
    desk.open("--pipe", "mitre_90")
    desk.until("adopt it so", 40.0)
    assert re.search("(front|rear) holds", desk.text)
    desk.press("1\r")
    desk.until("BY HAND", 40.0)
    desk.until(lambda: re.search(r"● \w+ +Fixed", desk.text))
    assert not desk.bay.drives
    desk.end()


def observe(desk: Desk) -> None:
    """What was recorded is shown again, and said to be a recording; so is what was seen."""
    runs = sorted((desk.folder / "runs").glob("*.mcap"))
    newest, noted = runs[-1], [it for it in runs if b"crack, 3 o'clock" in it.read_bytes()]
    assert "crack, 3 o'clock now" in said_by(desk, "map", str(noted[0]))
    said_by(desk, "report", str(noted[0]), "--output", "report.html")
    assert "crack, 3 o" in (desk.folder / "report.html").read_text(encoding="utf-8")
    desk.open(str(newest))
    desk.until("● RECORDING", 60.0)
    desk.end()

"""`pirate doctor` and `pirate calibrate`: look at a connected robot, and store its zeros."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from datetime import date
from math import degrees
from pathlib import Path

from pirate_sm.cli.errors import StoppedError, say, stopper
from pirate_sm.cli.options.declaring import read_duration
from pirate_sm.cli.options.devices import CalibrateOptions, DoctorOptions
from pirate_sm.cli.output.doctor_tables import LiveTables, plain_text
from pirate_sm.cli.output.terminal import agree, answered_line, is_terminal
from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import library, shown
from pirate_sm.core.loading import (
    LARGEST_ZERO_RAD,
    LoadedRobot,
    joints_of,
    keep_calibration,
    load_robot,
    newest_calibration,
    summary,
    with_zeros,
)
from pirate_sm.core.profile import Calibration
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import ANGLE, read_quantity
from pirate_sm.robot.backends.serial.assembly import STAY_S, guarded_port, read_plan
from pirate_sm.robot.diagnosis.facts import DoctorFinding, ExpectedRobot, Facts
from pirate_sm.robot.diagnosis.judgement import JointReading, judged, objections, read_joints
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.robot.diagnosis.moving import DUTY, TURN_FOR_S, Moving
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests

# --- a robot and a port -------------------------------------------------------------------------


def find_loaded(name: str | None) -> LoadedRobot:
    """Return the robot with this name or path; by default the first shipped one.

    Raises:
        LoadError: Its files cannot be used.
        UsageError: There is no such robot.
    """
    folder = library.find_robot(name, Path.cwd()) if name else library.robots()[0]
    return load_robot(folder)


def named_port(port: str | None) -> str:
    """Return the port of the options.

    Raises:
        UsageError: There is none.
    """
    if port is None:
        raise UsageError("name the port, --port /dev/ttyACM0, or set `port` (pirate config path)")
    return port


def subject_of(loaded: LoadedRobot, robot: RobotSpec) -> ExpectedRobot:
    """Return the robot with its plan of the serial link.

    Raises:
        UsageError: The robot has no serial link, its messages do not fit, or a library is missing.
    """
    return ExpectedRobot(loaded.profile, robot, read_plan(loaded.folder, loaded.profile, robot))


def connection(
    subject: ExpectedRobot,
    url: str,
    baud: int | None,
    requests: StopRequests,
    stay_s: float | None = None,
) -> Listening:
    """Return a connection to the robot, not opened yet; a guardian will own the port."""
    rate = baud or subject.plan.serial.baud
    port = guarded_port(subject.plan, url, baud, STAY_S if stay_s is None else stay_s)
    return Listening(subject, port, rate, stopper(requests))


# --- pirate doctor ------------------------------------------------------------------------------


GO, NO_GO = 0, 1


def run_doctor(options: DoctorOptions) -> int:
    """Print the findings about a connected robot; return 0 for go, 1 for no-go.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: An argument does not fit, or nobody confirmed --move.
        BackendError: There is no robot to connect to.
    """
    loaded = find_loaded(options.robot)
    robot, notices = loaded.normal, list[str]()
    calibration = newest_calibration(loaded) if options.calibration else None
    if calibration is not None:
        robot = with_zeros(robot, calibration.zeros)
        notices.append(summary(calibration))
    subject = subject_of(loaded, robot)
    if options.move and not options.yes:
        question = (
            f"Each wheel of {loaded.profile.robot} will turn for {TURN_FOR_S:g} s at "
            f"{DUTY:.0%}: is it on a block, with its wheels free?"
        )
        agree(question, nobody=f"{question} Agree to it with --yes")
    requests = StopRequests()
    try:
        with CaughtSignals(requests, ends_process=True):
            facts = _look(subject, options, requests)
    except StoppedError as stopped:
        say(f"{stopped}; whatever was turned has been stopped")
        return stopped.exit_code
    notes = tuple(DoctorFinding("note", notice) for notice in notices)
    facts = replace(facts, findings=(*facts.findings, *notes))
    if options.json:
        print(json.dumps(facts.as_data()))
    else:
        _show(facts, options)
    return GO if facts.go else NO_GO


def _look(subject: ExpectedRobot, options: DoctorOptions, requests: StopRequests) -> Facts:
    """Connect, collect all facts and judge them; release the port."""
    say(f"connecting to {named_port(options.port)} ...")
    stay_s = read_duration("--guard-for", options.guard_for)
    listening = connection(subject, named_port(options.port), options.baud, requests, stay_s)
    try:
        with listening:
            return _look_around(listening, subject, options)
    finally:
        if parting := listening.port.remark():
            say(parting)


def _look_around(listening: Listening, subject: ExpectedRobot, options: DoctorOptions) -> Facts:
    if left := listening.port.remark():
        say(left)
    say(f"listening for {options.seconds:g} s ...")
    with _live(options) as view:

        def watch(heard: Listening) -> None:
            if view is not None:
                view.update(judged(heard.facts(), subject), heard.port.now())

        listening.listen(options.seconds, watch)
    facts = judged(listening.facts(), subject)
    if not options.move:
        return facts
    moving = Moving(listening, say)
    if not facts.go:
        note = DoctorFinding("note", "nothing was sent: a robot that is no-go is not moved")
        others = tuple(each for each in facts.findings if each.level != "note")
        return replace(facts, findings=(*others, note))
    if moving.bearing:
        text = (
            f"nothing was sent: {', '.join(moving.bearing)} may bear a load; zeros could release "
            "what is held, and wheels could move it: if nothing can fall, relax the robot first"
        )
        return replace(facts, findings=(DoctorFinding("no-go", text), *facts.findings))
    move = moving.run()
    after = listening.facts().link
    link = replace(
        facts.link,
        echoed_ms=after.echoed_ms,
        repeats=after.repeats,
        damaged=after.damaged,
        resets=after.resets,
    )
    return judged(replace(facts, move=move, link=link), subject)


def _live(options: DoctorOptions) -> AbstractContextManager[LiveTables | None]:
    if options.json or options.plain or not is_terminal(sys.stdout):
        return nullcontext()
    return LiveTables()


def _show(facts: Facts, options: DoctorOptions) -> None:
    if options.plain or not is_terminal(sys.stdout):
        sys.stdout.write(plain_text(facts))
    else:
        LiveTables.show(facts)


# --- pirate calibrate ---------------------------------------------------------------------------


KEPT, REFUSED = 0, 1

LAY_DOWN = (
    "Take the robot out of its pipe and lay it on a flat table. Nothing will be sent to its "
    "motors, but opening the port has stopped those that were running."
)
STRAIGHTEN = (
    "Straighten it: every joint in line with its neighbours, along a ruler. The gears hold the "
    "joints; turn them with the robot's own controls."
)
HANDS_OFF = "Take your hands off."

_TURN_S = 0.1
_SHOW_EVERY_S = 0.5


def run_calibrate(options: CalibrateOptions) -> int:
    """Store the zeros of the joints; return 0, or 1 if the robot was not straight or still.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: An argument does not fit, or there is nobody to ask.
        BackendError: There is no robot to connect to.
    """
    if not (options.yes or sys.stdin.isatty()):
        raise UsageError("straighten the robot by hand: use a terminal, or say --yes")
    loaded = find_loaded(options.robot)
    joints = _joints(loaded, options.skip or ())
    limit_rad = LARGEST_ZERO_RAD
    if options.limit is not None:
        limit_rad = min(limit_rad, abs(read_quantity(options.limit, ANGLE)))
    subject = subject_of(loaded, loaded.normal)
    requests = StopRequests()
    try:
        with CaughtSignals(requests, ends_process=True):
            say(f"connecting to {named_port(options.port)} ...")
            with connection(subject, named_port(options.port), options.baud, requests) as listening:
                if left := listening.port.remark():
                    say(left)
                readings = _measure(listening, joints, options)
                return _conclude(listening, readings, limit_rad, loaded, options)
    except StoppedError as stopped:
        say(f"{stopped}; nothing was kept")
        return stopped.exit_code


def _joints(loaded: LoadedRobot, skip: Sequence[str]) -> tuple[str, ...]:
    joints = joints_of(loaded)
    if wrong := unknown("--skip: there is no joint", skip, joints):
        raise UsageError(wrong)
    left = tuple(name for name in joints if name not in skip)
    if not left:
        raise UsageError("there is no joint left to calibrate")
    return left


def _measure(
    listening: Listening, joints: Sequence[str], options: CalibrateOptions
) -> list[JointReading]:
    """Let the operator straighten the robot; return its joint readings afterwards."""

    def angles() -> str:
        return _line(read_joints(listening.subject, listening.records, joints))

    if not options.yes:
        _wait_for_enter(listening, LAY_DOWN)
        _wait_for_enter(listening, STRAIGHTEN, angles)
        _wait_for_enter(listening, HANDS_OFF)
    say(f"measuring for {options.seconds:g} s ...")
    listening.listen(options.seconds)
    return read_joints(listening.subject, listening.records, joints)


def _conclude(
    listening: Listening,
    readings: Sequence[JointReading],
    limit_rad: float,
    loaded: LoadedRobot,
    options: CalibrateOptions,
) -> int:
    before = _before(loaded)
    for name, mean, spread, *_ in readings:
        old = f", before {degrees(before[name]):+z.2f} deg" if name in before else ""
        print(f"{name}: {degrees(mean):+z.2f} deg, within {degrees(spread):.2f} deg{old}")
    against = objections(readings, limit_rad)
    if against:
        for objection in against:
            say(objection)
        say("nothing was kept; a joint whose sensor is broken can be left out with --skip JOINT")
        return REFUSED
    if not options.yes:
        _wait_for_enter(listening, "Keep these zeros? Ctrl-C keeps nothing.")
    calibration = Calibration(
        format=1,
        robot=loaded.profile.robot,
        date=date.today().isoformat(),
        port=named_port(options.port),
        zeros={reading.name: reading.mean for reading in readings},
    )
    path = keep_calibration(calibration, loaded)
    print(f"kept in {shown(path)}; missions on the real robot use them from now on")
    return KEPT


def _before(loaded: LoadedRobot) -> dict[str, float]:
    """Return the zeros in use before; empty if their file cannot be used."""
    try:
        newest = newest_calibration(loaded)
    except LoadError as error:
        say(str(error))
        return {}
    return newest.zeros if newest is not None else {}


def _line(readings: Sequence[JointReading]) -> str:
    """Return the angles of the joints, in one line."""
    return ", ".join(f"{each.name} {degrees(each.last):+z.1f} deg" for each in readings)


def _wait_for_enter(
    listening: Listening, what: str, status: Callable[[], str] = lambda: ""
) -> None:
    """Wait until the operator presses Enter; serve the link meanwhile.

    Raises:
        UsageError: Standard input has ended.
    """
    say(f"{what} [Enter]")
    try:
        _serve_until_enter(listening, status)
    finally:
        if status():
            say("")  # leave the status line


def _serve_until_enter(listening: Listening, status: Callable[[], str]) -> None:
    shown_s = listening.port.now()

    def turn() -> None:
        nonlocal shown_s
        listening.turn(listening.port.now() + _TURN_S)
        text = status()
        if text and listening.port.now() >= shown_s + _SHOW_EVERY_S:
            shown_s = listening.port.now()
            print(f"\r{text}\033[K", end="", file=sys.stderr, flush=True)

    if not answered_line(turn, look_s=0.0):
        raise UsageError("no answer; nothing was kept")

"""`pirate calibrate`: stores the joint angles of a straightened robot as its zeros."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from datetime import date
from math import degrees

from pirate_sm.cli.commands.doctor import connection, find_loaded, named_port, subject_of
from pirate_sm.cli.errors import StoppedError, say
from pirate_sm.cli.options.devices import CalibrateOptions
from pirate_sm.cli.output.terminal import answered_line
from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedRobot
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import ANGLE, read_quantity
from pirate_sm.robot.calibration_files import (
    LARGEST_ZERO_RAD,
    Calibration,
    joints_of,
    keep_calibration,
    newest_calibration,
)
from pirate_sm.robot.diagnosis.judgement import JointReading, objections, read_joints
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests

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

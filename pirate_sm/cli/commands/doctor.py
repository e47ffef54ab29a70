"""`pirate doctor`: reports what is connected to a port, and whether a mission may start."""

from __future__ import annotations

import json
import sys
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

from pirate_sm.cli.errors import StoppedError, say, stopper
from pirate_sm.cli.options.declaring import read_duration
from pirate_sm.cli.options.devices import DoctorOptions
from pirate_sm.cli.output.doctor_tables import LiveTables, plain_text, show_tables
from pirate_sm.cli.output.terminal import agree, is_terminal
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedRobot, load_robot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.serial.assembly import STAY_S, guarded_port, read_plan
from pirate_sm.robot.calibration_files import newest_calibration, summary, with_zeros
from pirate_sm.robot.diagnosis.facts import DoctorFinding, ExpectedRobot, Facts
from pirate_sm.robot.diagnosis.judgement import judged
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.robot.diagnosis.moving import DUTY, TURN_FOR_S, Moving
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests


def find_loaded(name: str | None) -> LoadedRobot:
    """Return the robot with this name or path; by default the first shipped one.

    Raises:
        LoadError: Its files cannot be used.
        UsageError: There is no such robot.
    """
    return load_robot(library.find_robot(name, Path.cwd()))


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
                view.show_sensors(judged(heard.facts(), subject), heard.port.now())

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
        show_tables(facts)

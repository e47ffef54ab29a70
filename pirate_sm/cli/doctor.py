"""`pirate doctor`: what is connected to a port, and whether a mission may start with it."""

from __future__ import annotations

import json
import sys
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

from pirate_sm.cli.connection import (
    StoppedError,
    agree,
    connection,
    find_loaded,
    subject_of,
)
from pirate_sm.cli.doctor_view import LiveTables, plain_text
from pirate_sm.cli.guard import say
from pirate_sm.cli.run import is_terminal, read_duration
from pirate_sm.diagnosis.facts import Facts, Finding, Subject
from pirate_sm.diagnosis.judgement import judged
from pirate_sm.diagnosis.listening import Listening
from pirate_sm.diagnosis.moving import DUTY, TURN_FOR_S, Moving
from pirate_sm.loading.calibration import newest_calibration, summary, with_zeros
from pirate_sm.runtime.stopping import CaughtSignals, StopRequests

GO, NO_GO = 0, 1


@dataclass(frozen=True)
class DoctorWishes:
    """The command line as it was given."""

    port: str
    robot: str | None
    baud: int | None
    seconds: float
    move: bool
    yes: bool
    guard_for: str | None
    plain: bool
    json: bool
    calibration: bool


def run_doctor(wishes: DoctorWishes) -> int:
    """0 for go, 1 for no-go; what was found is on standard output.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: An argument does not fit, or nobody agreed to --move.
        BackendError: There is no robot to connect to.
    """
    loaded = find_loaded(wishes.robot)
    robot, notices = loaded.normal, list[str]()
    calibration = newest_calibration(loaded) if wishes.calibration else None
    if calibration is not None:
        robot = with_zeros(robot, calibration.zeros)
        notices.append(summary(calibration))
    subject = subject_of(loaded, robot)
    if wishes.move:
        agree(
            f"Each wheel of {loaded.profile.robot} will turn for {TURN_FOR_S:g} s at "
            f"{DUTY:.0%}: is it on a block, with its wheels free?",
            wishes.yes,
        )
    requests = StopRequests()
    try:
        with CaughtSignals(requests, ends_process=True):
            facts = _look(subject, wishes, requests)
    except StoppedError as stopped:
        say(f"{stopped}; whatever was turned has been stopped")
        return stopped.exit_code
    notes = tuple(Finding("note", notice) for notice in notices)
    facts = replace(facts, findings=(*facts.findings, *notes))
    if wishes.json:
        print(json.dumps(facts.as_data()))
    else:
        _show(facts, wishes)
    return GO if facts.go else NO_GO


def _look(subject: Subject, wishes: DoctorWishes, requests: StopRequests) -> Facts:
    """Everything has been found out and judged; the port is free again."""
    say(f"connecting to {wishes.port} ...")
    stay_s = read_duration("--guard-for", wishes.guard_for)
    listening = connection(subject, wishes.port, wishes.baud, requests, stay_s)
    try:
        with listening:
            return _look_around(listening, subject, wishes)
    finally:
        if parting := listening.port.remark():
            say(parting)


def _look_around(listening: Listening, subject: Subject, wishes: DoctorWishes) -> Facts:
    if left := listening.port.remark():
        say(left)
    say(f"listening for {wishes.seconds:g} s ...")
    with _live(wishes) as view:

        def watch(heard: Listening) -> None:
            if view is not None:
                view.update(judged(heard.facts(), subject), heard.port.now())

        listening.listen(wishes.seconds, watch)
    facts = judged(listening.facts(), subject)
    if not wishes.move:
        return facts
    if not facts.go:
        note = Finding("note", "nothing was sent: a robot that is no-go is not moved")
        others = tuple(each for each in facts.findings if each.level != "note")
        return replace(facts, findings=(*others, note))
    move = Moving(listening, say).run()
    after = listening.facts().link
    link = replace(
        facts.link, echoed_ms=after.echoed_ms, repeats=after.repeats, damaged=after.damaged,
        resets=after.resets,
    )  # fmt: skip
    return judged(replace(facts, move=move, link=link), subject)


def _live(wishes: DoctorWishes) -> AbstractContextManager[LiveTables | None]:
    if wishes.json or wishes.plain or not is_terminal():
        return nullcontext()
    return LiveTables()


def _show(facts: Facts, wishes: DoctorWishes) -> None:
    if wishes.plain or not is_terminal():
        sys.stdout.write(plain_text(facts))
    else:
        LiveTables.show(facts)

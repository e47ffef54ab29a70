"""`--resume`, and robots that are not where their mission begins: compare, ask, continue.

A run continues only if that is safe and the operator agrees.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.gate import CheckError
from pirate_sm.cli.commands.run import Manner, run_prepared
from pirate_sm.cli.errors import StoppedError, say, stopper
from pirate_sm.cli.options.declaring import read_length
from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.cli.output.terminal import answered_line
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.options import OPTIONS
from pirate_sm.core.program import HERE, Do, Program, Wait
from pirate_sm.core.resuming import FAILURE, Reconciled, Resumption, VerdictTable
from pirate_sm.core.robot import states_of
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.wiring import Prepared, placed
from pirate_sm.running.wiring.adoption import Stands, adopt, begun_there, doubts, look_at, unplaced
from pirate_sm.running.wiring.resume_offer import (
    EndOfRun,
    Offer,
    Said,
    SeenRobot,
    check_said,
    counting_from,
    end_of_run,
    offer,
    see,
)
from pirate_sm.running.wiring.resumed_run import (
    check_place,
    driven_s,
    first_wheel_m,
    prepare_again,
    with_resumption,
)

# --- what is known ------------------------------------------------------------------------------


_NEXT = 3


class ResumeFacts(NamedTuple):
    """What is known when an operator is asked; ``dark_s`` is how long nobody has recorded, s."""

    end: EndOfRun
    loaded: LoadedMission
    dark_s: float
    shows: Reconciled
    offer: Offer
    said: Said


def report_lines(facts: ResumeFacts) -> Iterator[str]:
    """Yield the lines: where it was, what is seen, where the robot is, what comes next."""
    end, header, offer = facts.end, facts.end.recording.header, facts.offer
    phase = end.loaded.program.phase_of[end.last.mission.pc]
    yield f"{header.mission} on {header.backend}, began {header.began}"
    yield (
        f"cut off at {end.last_s - end.began_s:.3f} s in the phase {phase}, "
        f"{_doing(facts.loaded, end)}; dark for {_duration(facts.dark_s)}"
    )
    yield from (f"said: {each}" for each in facts.said.words)
    for table in facts.shows.tables if offer.table is None else (offer.table,):
        command = table.hypothesis.command
        yield f"  if {command} was accepted:" if command else "  as recorded:"
        yield from verdict_lines(table)
    yield f"position: {_position(facts)}"
    if offer.it is not None:
        names = list(_next_commands(facts.loaded, offer.it))
        yield f"next: {', '.join(names) or 'no command'}"
    yield from (f"unknown: {each}" for each in (*offer.unknown, *offer.unplaced))
    if offer.forecast is not None:
        why = f": {offer.forecast.why}" if offer.forecast.why else ""
        yield f"expected: {offer.forecast.word}{why}"
        yield from (f"    {each}" for each in offer.forecast.course)
    yield from (f"cannot continue: {each}" for each in offer.refusals)
    if not offer.refusals:
        yield "can continue" + " once you say where the robot is" * bool(offer.unplaced)


def verdict_lines(table: VerdictTable) -> Iterator[str]:
    """Yield what the sensors show of each state and clamp, and by which signals."""
    recorded = table.hypothesis.name != "adopted"
    for each in table.verdicts:
        why = f" ({each.why})" if each.why else ""
        yield f"    {each.word:12} {each.about} {each.state}{why}"
        for shown in each.shown:
            before = f"recorded {shown.recorded}, " * recorded
            yield f"                 {shown.signal} {shown.seen}, {before}limit {shown.limit}"


def _position(facts: ResumeFacts) -> str:
    way, was_m = facts.shows.way, first_wheel_m(facts.end)
    was = "not recorded" if was_m is None else f"first wheel at {was_m:.3f} m at the end"
    if facts.said.start_at_m is not None:
        return f"{was}; the operator says {facts.said.start_at_m:.3f} m now"
    if way.high_m == inf:
        return f"{was}, unknown since: {way.why}"
    middle_mm, off_mm = (500 * (way.high_m + sign * way.low_m) for sign in (1, -1))
    return f"{was}, {middle_mm:+.0f} mm ± {off_mm:.0f} mm since: {way.why}"


def _doing(loaded: LoadedMission, end: EndOfRun) -> str:
    motion, it = end.last.robot.motion, end.loaded.program.instructions[end.last.mission.pc]
    if motion is not None:
        return f"during {loaded.robot.commands[motion.command].name}"
    if end.maybe is not None:
        return f"{loaded.robot.commands[end.maybe].name} may have been sent since"
    return "waiting" if isinstance(it, Wait) else "between two commands"


def _next_commands(loaded: LoadedMission, it: Resumption) -> Iterator[str]:
    """Yield the next commands on the way that the file names first."""
    program: Program = it.program(loaded.program)
    at, seen, found = program.start, set[int](), 0
    while at >= 0 and at not in seen and found < _NEXT:
        seen.add(at)
        step = program.instructions[at]
        if isinstance(step, Do):
            found += 1
            yield loaded.robot.commands[step.command].name
        at = next(iter(program.successors(at)), -1)


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


# --- where the mission does not begin -----------------------------------------------------------


_ADOPT_QUESTION = "[1] adopt it so (or another number), [l]ook again, or leave [enter]? "
_PLACE = "wheel 1 is at which length along the pipe, such as 0.70 m [enter: unknown]? "


def take_over(
    prepared: Prepared, options: RunOptions | ConsoleOptions, requests: StopRequests
) -> tuple[Prepared, Resuming | None]:
    """Look at a real robot before its mission begins; return with what it begins.

    Nobody is asked if nothing contradicts the declared states. Where nobody can be asked nothing
    is looked at; then the engine refuses the start.

    Raises:
        BackendError: The robot cannot be reached, or has not confirmed that it holds.
        CheckError: The mission is refused if it begins where the robot is.
        StoppedError: A stop was requested.
        UsageError: Nobody has agreed to adopt the robot.
    """
    asks = sys.stdin.isatty() and sys.stderr.isatty() and not getattr(options, "yes", False)
    if prepared.engine.nominal or not (asks or options.adopt):
        return prepared, None
    check = stopper(requests)
    try:
        return _decided(prepared, options, asks, check)
    except BaseException:
        prepared.backend.close()
        raise


def _decided(
    prepared: Prepared, options: RunOptions | ConsoleOptions, asks: bool, check: Callable[[], None]
) -> tuple[Prepared, Resuming]:
    stands, agreed = look_at(prepared, check), -1
    while stands.instead:
        for table in stands.instead:
            if table.hypothesis.body.configuration == agreed:
                return adopt(prepared, stands, table)
        _print_stands(prepared, stands, getattr(options, "json", False))
        if len(stands.instead) == 1:
            _check_there(prepared, stands.instead[0])
        answer = _adopt_answer(prepared, stands, options.adopt, asks, check)
        if answer.isdecimal() and 0 < int(answer) <= len(stands.instead):
            if unplaced(prepared) and (place_m := ask_place(prepared.loaded, check)) is not None:
                prepared = placed(prepared, place_m)
            if not unplaced(prepared):
                agreed = stands.instead[int(answer) - 1].hypothesis.body.configuration
        elif answer != "l":
            raise UsageError("left as it is: nothing has moved")
        stands = look_at(prepared, check, stands)
    return prepared, stands.as_declared


def _check_there(prepared: Prepared, table: VerdictTable) -> None:
    """Refuse a mission that cannot begin where the robot is, before anything is asked.

    Raises:
        CheckError: It cannot; what to do is said.
    """
    try:
        begun_there(prepared, table)
    except CheckError:
        advice = "`pirate console` with the same options shows at which phases it can (h)"
        say(f"it cannot begin there; {advice}")
        raise


def ask_place(loaded: LoadedMission, check: Callable[[], None]) -> float | None:
    """Return where an operator says that the first wheel is, in m; None if unsaid."""
    print(_PLACE, end="", file=sys.stderr, flush=True)
    try:
        said_m = read_length("the first wheel", answered_line(check).strip() or None)
        check_place(loaded, said_m)
    except UsageError as error:
        say(str(error))
        return None
    return said_m


def _adopt_answer(
    prepared: Prepared, stands: Stands, adopts: bool, asks: bool, check: Callable[[], None]
) -> str:
    """Return the choice: a number, ``l``, or anything else to leave.

    Raises:
        UsageError: There is nobody to ask, and something that matters is unknown.
    """
    found = tuple(doubts(prepared, stands))
    if adopts and not found:
        return "1"
    if not asks:
        raise UsageError(f"--adopt is not enough: {'; '.join(found)}")
    print(_ADOPT_QUESTION, end="", file=sys.stderr, flush=True)
    return answered_line(check).strip().lower()


def _print_stands(prepared: Prepared, stands: Stands, json: bool) -> None:
    robot, declared = prepared.loaded.robot, stands.shows.tables[0]
    against = dict.fromkeys(each.why for each in declared.verdicts if each.word == "contradicted")
    lines = [f"the robot does not stand as declared: {'; '.join(against)}"]
    for number, table in enumerate(stands.instead, 1):
        lines.append(f"  {number}: {', '.join(states_of(robot, table.hypothesis.body))}")
        lines += verdict_lines(table)
    for line in lines:
        print(visible(line), file=sys.stderr if json else sys.stdout)
    sys.stdout.flush()


# --- --resume -----------------------------------------------------------------------------------


CAN, CANNOT, LEFT = 0, 1, 2

_MEANT_FOR = {
    *("resume", "look", "at", "accept", "states", "start_at_m", "port", "baud", "guard_for_s"),
    *("detector", "panel", "record", "no_record", "live", "yes", "plain", "json", "quiet"),
    *("debug", "version", "speed", "theme", "written", "breakpoints"),
}

_QUESTION = "[g]o on, [r]egrip (on_failure), [l]ook again, or leave [enter]? "


def resume_run(options: RunOptions, manner: Manner) -> int:
    """Resume a run that was cut off; return the exit code.

    Raises:
        BackendError: The robot cannot be reached.
        RecordingError: There is nothing to resume.
        UsageError: An option does not fit, or nobody has agreed; nothing has moved.
    """
    requests = StopRequests()
    dialog = resume_dialog(options, requests)
    with CaughtSignals(requests, ends_process=True):
        chosen = dialog.decide()
        if chosen is None:
            return dialog.code
        resumed, resuming = chosen
        return run_prepared(resumed, options, manner, requests, resuming)


def resume_dialog(options: RunOptions | ConsoleOptions, requests: StopRequests) -> ResumeDialog:
    """Read the recording of the options and prepare its run; nothing is connected yet.

    Raises:
        RecordingError: There is nothing to resume.
        UsageError: An option does not fit.
    """
    _check_options(options)
    end = end_of_run(Path(options.resume or ""))
    asked = options.order()
    said = Said(options.at or HERE, asked.states, asked.start_at_m)
    check_said(end.loaded, said)
    if isinstance(options, RunOptions):
        wishes = _Wishes(options.look, options.accept, options.json)
    else:
        wishes = _Wishes()
    return ResumeDialog(prepare_again(end, asked, say), end, said, wishes, requests)


def _check_options(options: RunOptions | ConsoleOptions) -> None:
    """Refuse options that the recording has.

    Raises:
        UsageError: One or more are given.
    """
    usual = {each.name: each.default for each in fields(options)}
    given = {**options.written, **{name: getattr(options, name) for name in usual}}
    usual |= {name: each.on_command_line for name, each in OPTIONS.items()}
    wrong = [
        "a mission" if name == "mission" else _flag(name)
        for name, value in given.items()
        if name not in _MEANT_FOR and value != usual.get(name)
    ]
    if wrong:
        raise UsageError(f"--resume takes them from the recording; leave out: {', '.join(wrong)}")
    if isinstance(options, RunOptions) and options.look and (options.accept or options.at):
        raise UsageError("--look only looks: leave out --accept and --at")


def _flag(name: str) -> str:
    return OPTIONS[name].flag if name in OPTIONS else f"--{name.replace('_', '-')}"


class _Wishes(NamedTuple):
    """How to decide: only to look; without asking; with standard output left to JSON."""

    look: bool = False
    accept: bool = False
    json: bool = False


class ResumeDialog:
    """Looks at the robot until it is decided how to resume.

    Attributes:
        prepared: The run as it was recorded.
        code: Exit code if it does not resume.
    """

    def __init__(
        self, prepared: Prepared, end: EndOfRun, said: Said, wishes: _Wishes, requests: StopRequests
    ) -> None:
        self.code = CANNOT
        self.prepared = prepared
        self._end, self._said, self._wishes = end, said, wishes
        self._stopper = stopper(requests)
        self._seen: SeenRobot | None = None
        self._asked = False
        # A simulated robot that is put back has not been in the dark at all.
        self._dark_s = _dark_s(end) if prepared.backend.real_time else 0.0

    def decide(self) -> tuple[Prepared, Resuming] | None:
        """Look at the robot and ask; return what it resumes with, None if it does not.

        The backend is closed unless it resumes.

        Raises:
            BackendError: The robot cannot be reached.
            UsageError: It cannot resume, or nobody has agreed.
        """
        chosen = None
        try:
            chosen = self._decide()
        except StoppedError as stopped:
            say(f"{stopped}; nothing has moved")
            self.code = stopped.exit_code
        finally:
            if chosen is None:
                self._close()
        return chosen

    def _decide(self) -> tuple[Prepared, Resuming] | None:
        prepared, end = self.prepared, self._end
        for notice in prepared.notices:
            say(notice)
        while True:
            seen = self._see()
            found = offer(prepared, end, seen, self._said)
            self._print(seen, found, self._said)
            if self._wishes.look:
                self.code = CANNOT if found.it is None else CAN
                return None
            answer, said = self._answer(found), self._said
            while answer == "r":
                said = replace(self._said, at=FAILURE)
                regrip = offer(prepared, end, seen, said)
                self._print(seen, regrip, said)
                if regrip.it is not None:
                    found = regrip
                    break
                answer, said = self._ask(), self._said  # the reason was printed last
            if answer in ("g", "r") and found.it is not None:
                if found.unplaced:
                    place_m = ask_place(end.loaded, self._stopper)
                    self._said = replace(self._said, start_at_m=place_m)
                elif chosen := self._agreed(seen, found.it, said):
                    return chosen
            elif answer != "l":
                say("left as it is: nothing has moved")
                self.code = LEFT
                return None

    def _agreed(
        self, seen: SeenRobot, it: Resumption, said: Said
    ) -> tuple[Prepared, Resuming] | None:
        """Return what it resumes with; None if the robot has changed since it was looked at."""
        prepared, end = self.prepared, self._end
        now = self._see() if self._asked and prepared.backend.real_time else seen
        if not now.shows.is_as(seen.shows, prepared.loaded.robot):
            say("the robot has changed since that was shown")
            return None
        it = it._replace(body=it.body._replace(next_id=now.next_id))
        resumed = with_resumption(counting_from(prepared, end, now, said), end, it, said.words)
        return resumed, Resuming(it, now.look.now_s, now.look.newest)

    def _see(self) -> SeenRobot:
        end, driven = self._end, driven_s(self._end, self._dark_s)
        self._seen = see(self.prepared, end, driven, self._seen, self._check)
        return self._seen

    def _close(self) -> None:
        self.prepared.backend.close()
        if parting := self.prepared.parting():
            say(parting)

    def _check(self, text: str) -> None:
        self._stopper()
        if text:
            say(text)

    def _print(self, seen: SeenRobot, found: Offer, said: Said) -> None:
        out = sys.stderr if self._wishes.json else sys.stdout
        facts = ResumeFacts(self._end, self.prepared.loaded, self._dark_s, seen.shows, found, said)
        for line in report_lines(facts):
            print(visible(line), file=out)
        out.flush()

    def _answer(self, found: Offer) -> str:
        """Return the choice: ``g``, ``r``, ``l``, or anything else to leave.

        Raises:
            UsageError: It cannot resume, or there is nobody to agree.
        """
        if self._wishes.accept and not found.doubts:
            return "g"
        if found.refusals:
            raise UsageError(f"it cannot continue: {'; '.join(found.refusals)}")
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            if self._wishes.accept:
                raise UsageError(f"--accept is not enough: {'; '.join(found.doubts)}")
            raise UsageError("it can continue: agree to it on a terminal, or with --accept")
        return self._ask()

    def _ask(self) -> str:
        self._asked = True
        print(_QUESTION, end="", file=sys.stderr, flush=True)
        return answered_line(self._stopper).strip().lower()[:1]


def _dark_s(end: EndOfRun) -> float:
    """Return how long nobody has recorded, by the clocks of this machine, s; at least 0."""
    began = datetime.fromisoformat(end.recording.header.began)
    since_s = (datetime.now(UTC) - began).total_seconds()
    return max(0.0, since_s - (end.last_s - end.began_s))

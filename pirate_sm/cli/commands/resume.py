"""`--resume`: looks at a robot whose run was cut off, and goes on if that is safe and agreed."""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.cli.output.resume_report import ResumeFacts, report_lines
from pirate_sm.cli.output.terminal import answered_line
from pirate_sm.cli.shown_run import Manner, run_prepared
from pirate_sm.cli.stop_checks import StoppedError, stopper
from pirate_sm.cli.taking_over import ask_place
from pirate_sm.core.errors import UsageError
from pirate_sm.core.options import OPTIONS
from pirate_sm.core.program import HERE
from pirate_sm.core.resuming import FAILURE, Resumption
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.wiring import Prepared
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
from pirate_sm.running.wiring.resumed_run import driven_s, prepare_again, with_resumption

CAN, CANNOT, LEFT = 0, 1, 2

_MEANT_FOR = {
    *("resume", "look", "at", "accept", "states", "start_at_m", "port", "baud", "guard_for_s"),
    *("detector", "panel", "record", "no_record", "live", "yes", "plain", "json", "quiet"),
    *("debug", "version", "speed", "theme", "written"),
}

_QUESTION = "[g]o on, [r]egrip (on_failure), [l]ook again, or leave [enter]? "


def resume_run(options: RunOptions, manner: Manner) -> int:
    """Go on with a run that was cut off; return the exit code.

    Raises:
        BackendError: The robot cannot be reached.
        RecordingError: There is nothing to go on from.
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
        RecordingError: There is nothing to go on from.
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
    """Looks at the robot until it is decided how to go on.

    Attributes:
        prepared: The run as it was recorded.
        code: Exit code if it does not go on.
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
        """Look at the robot and ask; return with what it goes on, None if it does not.

        The backend is closed unless it goes on.

        Raises:
            BackendError: The robot cannot be reached.
            UsageError: It cannot go on, or nobody has agreed.
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
        """Return with what it goes on; None if the robot has changed since it was looked at."""
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
            UsageError: It cannot go on, or there is nobody to agree.
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

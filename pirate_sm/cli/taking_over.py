"""Asks whether a robot that is not where its mission begins is adopted as its sensors show it."""

from __future__ import annotations

import sys
from collections.abc import Callable

from pirate_sm.checking.gate import CheckError
from pirate_sm.cli.errors import say
from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.cli.options.values import read_length
from pirate_sm.cli.output.resume_report import verdict_lines
from pirate_sm.cli.output.terminal import answered_line
from pirate_sm.cli.stop_checks import stopper
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.resuming import VerdictTable
from pirate_sm.core.robot import states_of
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.wiring import Prepared, placed
from pirate_sm.running.wiring.adoption import Stands, adopt, begun_there, doubts, look_at, unplaced
from pirate_sm.running.wiring.resumed_run import check_place

_QUESTION = "[1] adopt it so (or another number), [l]ook again, or leave [enter]? "
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
        _print(prepared, stands, getattr(options, "json", False))
        if len(stands.instead) == 1:
            _check_there(prepared, stands.instead[0])
        answer = _answer(prepared, stands, options.adopt, asks, check)
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
    """Return where a person says that the first wheel is, in m; None if unsaid."""
    print(_PLACE, end="", file=sys.stderr, flush=True)
    try:
        said_m = read_length("the first wheel", answered_line(check).strip() or None)
        check_place(loaded, said_m)
    except UsageError as error:
        say(str(error))
        return None
    return said_m


def _answer(
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
    print(_QUESTION, end="", file=sys.stderr, flush=True)
    return answered_line(check).strip().lower()


def _print(prepared: Prepared, stands: Stands, json: bool) -> None:
    robot, declared = prepared.loaded.robot, stands.shows.tables[0]
    against = dict.fromkeys(each.why for each in declared.verdicts if each.word == "contradicted")
    lines = [f"the robot does not stand as declared: {'; '.join(against)}"]
    for number, table in enumerate(stands.instead, 1):
        lines.append(f"  {number}: {', '.join(states_of(robot, table.hypothesis.body))}")
        lines += verdict_lines(table)
    for line in lines:
        print(visible(line), file=sys.stderr if json else sys.stdout)
    sys.stdout.flush()

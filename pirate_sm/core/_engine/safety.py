"""Safety rules, and faults found in the signals.

*Rules* are evaluated during every run, and before a command that could break one is sent. Their
conditions see the commanded robot. Words: the state of each region, and the command just accepted.
Numbers: how many parts are held, how many are confirmed to hold, and how many wheels are driven.
The progress of a rule is one integer: the number of commands that may still be accepted until it
must hold, or one of two special values.

*Faults* are those of the rules of the profile, silent boards and channels without a value.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf, isnan, log, nan
from typing import NamedTuple

from pirate_sm.core._engine.mission.program import Program, RuleSpec
from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.robot import commands
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState, confirmed_parts, states_of
from pirate_sm.core._engine.sensing import plausibility
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, LinkSpec
from pirate_sm.core._engine.sensing.evaluator import GAIN
from pirate_sm.core._engine.sensing.known_signals import Sensing, nothing_known
from pirate_sm.core._engine.sensing.odometry import unheard
from pirate_sm.core._engine.state import FaultState, Words
from pirate_sm.core._model.events import ALPHABET_VERSION, EVIDENCE_ENDS, FaultReport, SubmitResult
from pirate_sm.core._model.faults import BuiltInFault

# --- rules ------------------------------------------------------------------------------------


NUMBERS = ("clamps", "confirmed_clamps", "driven_wheels")
"""The numbers that conditions of rules can use, in this order."""

COMMAND = "command"
"""The word after the regions: the command just accepted; unknown at other times."""

RULE_BROKEN = BuiltInFault.RULE_VIOLATED.code

_NOT_YET = -1
_IN_FORCE = 0


def unseen(program: Program) -> tuple[int, ...]:
    """Return the initial progress of every rule."""
    return (_NOT_YET,) * len(program.rules)


def follow(
    program: Program,
    robot: RobotSpec,
    before: tuple[int, ...],
    body: RobotState,
    steps: int,
    command: str | None = None,
) -> tuple[tuple[int, ...], tuple[RuleSpec, ...]]:
    """Return the progress of every rule for this state of the robot, and the violated rules.

    Args:
        program: The program with the rules.
        robot: The robot.
        before: The progress of the rules so far.
        body: The commanded state of the robot.
        steps: How many commands have been accepted since ``before``.
        command: The command just accepted, if any.
    """
    if not program.rules:
        return (), ()
    driven = sum([body.values[slot] != 0 for slot in robot.safe_zero])
    numbers = (
        float(len(robot.held[body.configuration])),
        float(len(confirmed_parts(robot, body))),
        float(driven),
    )
    words = (*states_of(robot, body), command)
    after, broken = [], []
    for rule, at in zip(program.rules, before, strict=True):
        begins = rule.after is None or rule.after.evaluate(numbers, words) is True
        holds = rule.must.evaluate(numbers, words)
        if rule.within is None:
            now = _IN_FORCE if begins or at == _IN_FORCE else _NOT_YET
            violated = now == _IN_FORCE and holds is False  # unknown where no command is accepted
        elif holds:
            now, violated = _NOT_YET, False
        elif at > 0:
            now = max(at - steps, 0)
            violated = now == 0
        else:
            now, violated = (rule.within if begins else _NOT_YET), False
        after.append(now)
        if violated:
            broken.append(rule)
    return tuple(after), tuple(broken)


def broken(moment: Moment, places: tuple[int, ...], body: RobotState) -> tuple[RuleSpec, ...]:
    """Return the rules that the robot breaks in this state, although no command is accepted."""
    return follow(moment.program, moment.robot, places, body, 0)[1]


def forbids(moment: Moment, places: tuple[int, ...], begun: RobotState) -> str:
    """Return the rules that a command would break at its acceptance, as text; empty if none.

    Args:
        moment: The context, with robot and program.
        places: The progress of the rules.
        begun: The robot after the command has begun.
    """
    flight, motion = begun.flight, begun.motion
    if not places or flight is None or motion is None:
        return ""
    accepted = SubmitResult(flight.setpoint_id, "accepted")
    body, _ = commands.resolve(moment.trial(), begun, accepted)
    name = moment.robot.commands[motion.command].name
    _, broken = follow(moment.program, moment.robot, places, body, 1, name)
    return "; ".join(said(rule) for rule in broken)


def said(rule: RuleSpec) -> str:
    """Return the rule as one line of text."""
    return f"rule {rule.name} ({rule.text})" + (f": {rule.why}" if rule.why else "")


# --- faults -----------------------------------------------------------------------------------


STARTS_AGAIN = frozenset({BuiltInFault.FIRMWARE_RESET.code, BuiltInFault.LINK_INTERRUPTED.code})
"""Faults after which all signals are unknown again, and counters may start at zero.

The robot is another one until its sensors show the one that was known."""


class FoundFault(NamedTuple):
    """A new fault.

    Attributes:
        denies: The parts whose clamps it shows not to hold.
        of: The boards, joints, wheels and parts that it is a fault of.
    """

    code: str
    message: str
    catchable: bool
    denies: frozenset[int] = frozenset()
    of: tuple[str, ...] = ()

    @classmethod
    def built_in(cls, fault: BuiltInFault, message: str, *of: str) -> FoundFault:
        """Return a built-in fault with its message."""
        return cls(fault.code, message, fault.catchable, of=of)

    @classmethod
    @lru_cache(maxsize=256)
    def reported(cls, robot: RobotSpec, report: FaultReport) -> FoundFault:
        """Return the fault of a report."""
        rule = robot.rule_of(report)
        return cls(
            report.code,
            report.message,
            robot.fault_codes.get(report.code, True),
            rule.denies if rule else frozenset(),
            report.of or (rule.of if rule else ()),
        )


def no_faults(robot: RobotSpec, now_s: float = 0.0) -> FaultState:
    """Return the fault state of a robot without known faults, which is listened to from now on."""
    return FaultState((nan,) * len(robot.faults), listening_s=now_s)


def look(
    robot: RobotSpec,
    faults: FaultState,
    board: BoardSpec,
    sensing: Sensing,
    words: Words,
    now: float,
) -> tuple[FaultState, tuple[FoundFault, ...]]:
    """Return the fault state after a board's frame, and the faults that it shows.

    Only rules that depend on the board's signals are evaluated. A rule is raised once its condition
    has held long enough, and again only after the condition was false or unknown in between.
    """
    numbers = sensing.numbers
    since: list[float] | None = None
    raised = faults.raised
    found: list[FoundFault] = []
    for index in board.faults:
        rule = robot.faults[index]
        began = faults.since[index]
        if rule.when.evaluate(numbers, words) is not True:
            if not isnan(began):
                since = list(faults.since) if since is None else since
                since[index] = nan
                raised -= {index}
            continue
        if isnan(began):
            since = list(faults.since) if since is None else since
            since[index] = began = now
        if index not in raised and has_come(now, began + rule.held_s):
            raised |= {index}
            found.append(FoundFault(rule.code, rule.message, rule.catchable, rule.denies, rule.of))
    blind, unseen = _blind(robot, faults.blind, board, sensing)
    found += unseen
    silent = faults.silent - {board.position} if faults.silent else faults.silent
    if since is None and raised is faults.raised and blind is faults.blind:
        return (faults if silent == faults.silent else faults._replace(silent=silent)), ()
    times = faults.since if since is None else tuple(since)
    known = faults._replace(since=times, raised=raised, silent=silent, blind=blind)
    return known, tuple(found)


def _blind(
    robot: RobotSpec, blind: frozenset[int], board: BoardSpec, sensing: Sensing
) -> tuple[frozenset[int], list[FoundFault]]:
    """Return the channels without a value, and a fault for each one that has just lost its value.

    An implausible value is reported separately and does not count as missing.
    """
    found: list[FoundFault] = []
    numbers, doubted = sensing.numbers, sensing.records[board.position].doubted
    if not blind and not isnan(sum([numbers[target] for _, target, _ in board.channels])):
        return blind, found  # the sum is NaN if any value is
    for _, target, _ in board.channels:
        if (isnan(numbers[target]) and target not in doubted) != (target in blind):
            blind ^= {target}
            if target in blind:
                name = robot.vocabulary.numbers[target]
                of = robot.owners.measured[target]
                message = f"{name} has no value"
                found.append(FoundFault.built_in(BuiltInFault.SENSOR_SILENT, message, of))
    return blind, found


def unsettle(robot: RobotSpec, faults: FaultState, sensing: Sensing, words: Words) -> FaultState:
    """Restart the rules that no longer hold because boards have become silent (rule 7)."""
    since = tuple(
        began if rule.when.evaluate(sensing.numbers, words) is True else nan
        for rule, began in zip(robot.faults, faults.since, strict=True)
    )
    raised = frozenset(index for index in faults.raised if not isnan(since[index]))
    return faults._replace(since=since, raised=raised)


def start_again(robot: RobotSpec, sensing: Sensing, now: float, away_s: float) -> Sensing:
    """Return unknown signals, with the odometry kept: it omits what was rolled unobserved.

    Args:
        robot: The robot.
        sensing: The signals before.
        now: When it is.
        away_s: How long the controller was silent; NaN if nobody knows.
    """
    fresh = nothing_known(robot)
    numbers = list(fresh.numbers)
    if robot.odometry >= 0:
        numbers[robot.odometry] = sensing.numbers[robot.odometry]
    heard_s = (now,) * len(fresh.heard_s)  # each board gets its full time to report
    records = tuple(map(plausibility.start_again, sensing.records))
    return fresh._replace(
        numbers=tuple(numbers),
        heard_s=heard_s,
        checked_s=now,
        records=records,
        loss=sensing.loss,
        adrift=sensing.adrift,
        connection=sensing.connection + 1,
        distance=unheard(robot, sensing, now, away_s),
    )


def listen(
    robot: RobotSpec,
    faults: FaultState,
    sensing: Sensing,
    now: float,
    alphabet: int = ALPHABET_VERSION,
) -> tuple[FaultState, tuple[FoundFault, ...]]:
    """Report each board once that has been silent for too long; all boards together mean the link.

    The limit of a single board is longer where reports are lost, and while nobody knows yet how
    many are, except in recordings of an older alphabet. A single board is judged only while
    others report: when the link fails, one board always becomes silent first.
    """
    silent_after_s, heard_s = robot.link.silent_after_s, sensing.heard_s
    newest_s = max(heard_s, default=now)
    if newest_s <= now - silent_after_s:
        every = frozenset(range(len(heard_s)))
        if every <= faults.silent:
            return faults, ()
        message = f"no board has reported for {silent_after_s:g} s"
        return faults._replace(silent=every), (
            FoundFault.built_in(BuiltInFault.LINK_SILENT, message),
        )
    if newest_s <= now - silent_after_s / 2:
        return faults, ()
    due = len(heard_s) * (now - faults.listening_s) / robot.link.period_s
    due = due if alphabet >= EVIDENCE_ENDS else inf
    limit_s = silent_limit_s(robot.link, sensing.loss, due)
    silent = frozenset(at for at, each_s in enumerate(heard_s) if each_s <= now - limit_s)
    new = silent - faults.silent
    if not new:
        return faults, ()
    return faults._replace(silent=silent | faults.silent), tuple(
        FoundFault.built_in(
            BuiltInFault.SENSOR_SILENT,
            f"board {board.id} ({board.module}) has not reported for {limit_s:.3g} s",
            board.name,
        )
        for board in robot.boards.values()
        if board.position in new
    )


# --- how long a board may be silent where reports are lost ------------------------------------


_FALSE_ALARM = 1e-6
"""Probability per report that a board is taken for silent although it reports."""


_UNTRIED = 0.5
"""Loss assumed before the first report, of a line that changes 1 % of all bytes and loses 20 %."""


LONGEST = 5.0
"""Upper limit as a multiple of ``silent_after``: a silent board is found within it at any loss."""


def silent_limit_s(link: LinkSpec, loss: float, reports: float = inf) -> float:
    """Return how long a single board may be silent.

    That is ``silent_after``, or on a lossy line the number of periods that makes a false alarm
    rare, at most :data:`LONGEST` times ``silent_after``.

    Args:
        link: Timing of the link.
        loss: The share of lost reports so far, a running mean that begins at 0.
        reports: How many reports all boards have been due to send since then. While they are few,
            the share says little, and the line may lose half.
    """
    loss += _UNTRIED * (1 - GAIN) ** reports
    if loss <= 0:
        return link.silent_after_s
    patience_s = link.period_s * log(_FALSE_ALARM) / log(loss) if loss < 1 else inf
    return min(max(link.silent_after_s, patience_s), LONGEST * link.silent_after_s)

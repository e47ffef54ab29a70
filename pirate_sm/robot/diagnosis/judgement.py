"""Judge the facts about a connected robot: go or no-go, and why; whether it is straight."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import degrees, hypot, radians
from statistics import median
from typing import NamedTuple

from pirate_sm.core.geometry import GRAVITY_M_S2
from pirate_sm.core.models import Advice, Board, Channel
from pirate_sm.robot.backends.serial.link.conversation import NO_SENSORS, mute
from pirate_sm.robot.diagnosis.facts import (
    BoardFact,
    ChannelFact,
    DoctorFinding,
    ExpectedRobot,
    Facts,
    MoveFact,
    Records,
    TopicFact,
    meanings,
)

LATE_SHARE = 0.5
"""A board that reports less often than this share of what it should is suspicious."""

DAMAGED_SHARE = 0.01

COMPLETE_SHARE = 0.9
"""Of the messages that the bus has time for."""


STALLED_SHARE = 0.5
"""A computer that stands still for this share of what its guardian allows is suspicious."""

SLOW_MS = 150.0
_ERROR = 3


def judged(facts: Facts, subject: ExpectedRobot) -> Facts:
    """Return the facts with what is wrong with each sensor, and all findings, worst first."""
    boards = tuple(judge_board(board, subject) for board in facts.boards)
    facts = replace(facts, boards=boards)
    findings = [each for _, check in CHECKS.values() for each in check(facts, subject)]
    findings += _about_moving(facts, _advice(subject))
    order = ("no-go", "suspicious", "note")
    findings.sort(key=lambda finding: order.index(finding.level))
    return replace(facts, findings=tuple(findings))


def _advice(subject: ExpectedRobot) -> Advice:
    return subject.plan.serial.advice


def _with(advice: str) -> str:
    return f": {advice}" if advice else ""


# --- topics -------------------------------------------------------------------------------------


def _about_topics(facts: Facts, subject: ExpectedRobot) -> Iterator[DoctorFinding]:
    for refusal in facts.refused:
        yield DoctorFinding("no-go", refusal)
    reasons = " ".join(facts.refused)
    for topic in facts.topics:
        if topic.id is None:
            yield DoctorFinding("no-go", _missing(topic, facts))
        elif not topic.agrees and topic.type not in reasons:
            yield DoctorFinding(
                "no-go",
                f"topic '{topic.name}' carries {topic.type} with md5 {topic.md5}, the profile "
                f"says {topic.our_type} with {topic.our_md5}",
            )


def _missing(topic: TopicFact, facts: Facts) -> str:
    others = [t.name for t in facts.topics if not t.our_type and t.direction == topic.direction]
    there = f"; it {topic.direction} {', '.join(others)}" if others else ""
    return (
        f"the device does not say that it {topic.direction} '{topic.name}'{there}: put the names "
        "and types of its firmware into section 'serial' of the profile"
    )


# --- boards -------------------------------------------------------------------------------------


def _about_boards(facts: Facts, subject: ExpectedRobot) -> Iterator[DoctorFinding]:
    silent = [board.id for board in facts.boards if not board.frames]
    if silent and len(silent) == len(facts.boards):
        advice = _advice(subject).no_sensors
        if all(topic.agrees and topic.id is not None for topic in facts.topics):
            message = f"no board reports{_with(advice)}" if advice else NO_SENSORS
            yield DoctorFinding("no-go", message)
    elif silent:
        yield DoctorFinding(
            "no-go",
            f"{mute(subject.plan.modules, silent)}: is it powered, is its cable in? A board that "
            "is meant to be absent is 'fitted: false' in the profile",
        )
    else:
        yield from _about_rates(facts, subject)
    if facts.strangers:
        boards = ", ".join(map(str, facts.strangers))
        message = f"board {boards} reports, which the profile does not listen to"
        yield DoctorFinding("suspicious", message)


def _about_rates(facts: Facts, subject: ExpectedRobot) -> Iterator[DoctorFinding]:
    most_s = min(subject.profile.link.silent_after, facts.listened_s / 2)
    if facts.boards and all(board.longest_gap_s > most_s for board in facts.boards):
        least_s = min(board.longest_gap_s for board in facts.boards)
        yield DoctorFinding("no-go", f"no board reported for {least_s:.1f} s in between")
        return
    share = sum(b.per_s for b in facts.boards) / sum(b.expected_per_s for b in facts.boards)
    if share < COMPLETE_SHARE:
        yield DoctorFinding(
            "suspicious",
            f"only {share:.0%} of the expected messages arrive: messages are lost, "
            "or its cycle is longer than the profile says",
        )
    for board in facts.boards:
        what = f"board {board.id} ({board.module})"
        if board.longest_gap_s > most_s:
            message = f"{what} said nothing for {board.longest_gap_s:.1f} s"
            yield DoctorFinding("no-go", message)
        elif board.per_s < LATE_SHARE * board.expected_per_s:
            yield DoctorFinding(
                "suspicious",
                f"{what} reports {board.per_s:.1f} times a second instead of "
                f"{board.expected_per_s:.1f}",
            )


# --- sensors ------------------------------------------------------------------------------------


def _about_channels(facts: Facts, _: ExpectedRobot) -> Iterator[DoctorFinding]:
    for board in facts.boards:
        for channel in board.channels:
            name = channel.signal or f"{channel.name} of board {board.id}"
            for trouble in channel.trouble:
                wrong = trouble.startswith(name)
                yield DoctorFinding("suspicious", trouble if wrong else f"{name} {trouble}")


# --- link ---------------------------------------------------------------------------------------


def _about_link(facts: Facts, subject: ExpectedRobot) -> Iterator[DoctorFinding]:
    link, most_s = facts.link, subject.plan.serial.heartbeat_within
    if link.stood_still_s > STALLED_SHARE * most_s:
        yield DoctorFinding(
            "suspicious",
            f"this computer stood still for {link.stood_still_s:.2f} s, and a robot that drives is "
            f"stopped after {most_s:g} s (heartbeat_within): end other programs, plug in its power "
            "supply, or let this program go first (`@dialout - nice -10` in a file of "
            "/etc/security/limits.d, then log in again)",
        )
    if link.resets:
        message = "the device fell silent and had to be asked again: it was reset"
        yield DoctorFinding("no-go", message)
    if link.dropped > DAMAGED_SHARE * max(link.bytes, 1):
        yield DoctorFinding(
            "suspicious",
            f"{link.dropped} of {link.bytes} bytes belonged to no whole frame: a bad cable, a "
            "disturbed line, or another program that uses the port",
        )
    if link.unreadable:
        message = f"{link.unreadable} messages do not match their declared type"
        yield DoctorFinding("suspicious", message)
    if link.asked_ms and median(link.asked_ms) > SLOW_MS:
        message = f"the device takes {median(link.asked_ms):.0f} ms to answer"
        yield DoctorFinding("suspicious", message)
    for level, text in facts.words:
        if level >= _ERROR:
            yield DoctorFinding("suspicious", f"the firmware says: {text}")


Check = Callable[[Facts, ExpectedRobot], Iterator[DoctorFinding]]

CHECKS: Mapping[str, tuple[str, Check]] = {
    "topics": ("names and types are those of the profile", _about_topics),
    "boards": ("every board reports, as often as it should", _about_boards),
    "sensors": ("every sensor shows what it can show at rest", _about_channels),
    "link": ("no reset, hardly any damage, no delay", _about_link),
}
"""What can be checked while nothing moves: what is right, and what returns what is wrong."""

CHECKED_EVERY_S = 3.0
"""How often a link that a run has open is checked: long enough for each board to report more often
than a live sensor repeats a value."""


# --- moving -------------------------------------------------------------------------------------


def _about_moving(facts: Facts, advice: Advice) -> Iterator[DoctorFinding]:
    move = facts.move
    if move is None:
        message = "nothing was sent, so it is unknown whether the motors obey (see --move)"
        if advice.no_motion:
            message += f"; if they do not, {advice.no_motion}"
        yield DoctorFinding("note", message)
    elif not move.accepted:
        yield DoctorFinding("no-go", f"none of {move.sent} arrays of setpoints was echoed")
    elif move.accepted < move.sent:
        lost = move.sent - move.accepted
        message = f"{lost} of {move.sent} arrays of setpoints were never echoed"
        yield DoctorFinding("no-go", message)
    elif move.wheels:
        yield from _about_wheels(move, advice)


def _about_wheels(move: MoveFact, advice: Advice) -> Iterator[DoctorFinding]:
    if all(wheel.turned_rad is None for wheel in move.wheels):
        message = "setpoints are echoed, but no wheel's sensor shows whether it turned"
        yield DoctorFinding("suspicious", message)
        return
    idle = [wheel for wheel in move.wheels if not wheel.turned]
    if len(idle) == len(move.wheels):
        message = f"setpoints are echoed but no wheel turns{_with(advice.no_motion)}"
        yield DoctorFinding("no-go", message)
        return
    for wheel in idle:
        unseen = wheel.turned_rad is None
        why = "its sensor reports nothing" if unseen else "its sensor does not see it turn"
        message = f"{wheel.slot} was driven and {why}: it is dead, blocked, or not seen"
        yield DoctorFinding(
            "suspicious", message + _with(advice.motor_error).replace(": ", "; ", 1)
        )
    if not idle:
        yield DoctorFinding("note", f"all {len(move.wheels)} wheels obey")


SAME = 20
"""More equal values in a row than chance allows: an angle flickers by a count."""


AT_END_RAD = radians(3)


GRAVITY_WITHIN = 2.5
"""m/s²; a robot at rest measures gravity alone."""


def judge_board(fact: BoardFact, subject: ExpectedRobot) -> BoardFact:
    """Return the fact with the problems of each of the board's sensors."""
    board = next(each for each in subject.profile.boards if each.id == fact.id)
    channels = [
        replace(channel, trouble=(*channel.trouble, *_trouble(channel, known, fact, subject)))
        for channel, known in zip(fact.channels, board.channels, strict=True)
    ]
    _judge_gravity(channels, board)
    return replace(fact, channels=tuple(channels))


def _trouble(
    channel: ChannelFact, known: Channel, board: BoardFact, subject: ExpectedRobot
) -> Iterator[str]:
    if channel.raw is None:
        if board.frames:
            yield "says nothing"
        return
    if channel.spikes:
        times = "once" if channel.spikes == 1 else f"{channel.spikes} times"
        yield f"has spiked {times}, between {channel.least:g} and {channel.most:g} counts"
    joint = next((j for j in subject.profile.body.joints if j.name == channel.signal), None)
    noisy = joint is not None or (known.senses or "").startswith("acc")
    if noisy and channel.same >= SAME:
        times = f"{channel.same} times in a row"
        yield f"has shown exactly the same {times}: a live sensor flickers a little"
    value = channel.value
    if joint is not None and value is not None and not channel.trouble:
        beyond = joint.end_stop - abs(value)
        if beyond < AT_END_RAD:
            yield f"is at its end stop ({degrees(joint.end_stop):g} deg either way)"
    slot = next((s for s in subject.profile.slots if s.name == known.slot), None)
    limited = known.senses == "angle" and slot is not None and slot.unit == "angle"
    limit = slot.limit if limited and slot is not None else None
    if limit is not None and value is not None and abs(value) > limit + AT_END_RAD:
        yield f"is beyond its limit of {degrees(limit):g} deg either way"


def _judge_gravity(channels: list[ChannelFact], board: Board) -> None:
    """Report an accelerometer that does not measure gravity, at its first axis."""
    axes = [
        at for at, known in enumerate(board.channels) if (known.senses or "").startswith("acc_")
    ]
    values = [value for at in axes if (value := channels[at].value) is not None]
    if not axes or len(values) < len(axes):
        return
    felt = hypot(*values)
    if abs(felt - GRAVITY_M_S2) > GRAVITY_WITHIN:
        first = channels[axes[0]]
        trouble = (
            f"and its other axes make {felt:.1f} m/s^2 together, gravity is {GRAVITY_M_S2}: the"
            " scale in the profile is wrong, or the sensor is"
        )
        channels[axes[0]] = replace(first, trouble=(*first.trouble, trouble))


# --- straightness ---------------------------------------------------------------------------------


STILL_RAD = radians(1)
"""A joint at rest flickers by less than this; a count is a tenth of it."""

LEAST_READINGS = 10


class JointReading(NamedTuple):
    """One joint's readings, without a zero subtracted.

    Attributes:
        mean: Mean, rad; likewise ``spread``, the difference of the extremes, and ``last``.
        taken: Number of readings.
    """

    name: str
    mean: float
    spread: float
    taken: int
    last: float


def read_joints(
    subject: ExpectedRobot, records: Records, joints: Sequence[str]
) -> list[JointReading]:
    """Return the readings of these joints since counting began."""
    found: list[JointReading] = []
    for number, record in records.boards.items():
        scales = {place: scale for place, (scale, _, _) in meanings(subject, number).items()}
        for place, channel in enumerate(record.board.channels):
            if channel.signal is not None and channel.signal in joints and place in scales:
                counted, scale = record.channels[place], abs(scales[place])
                spread = (counted.most - counted.least) * scale if counted.count else 0.0
                mean = counted.mean * scales[place]
                last = counted.last * scales[place]
                found.append(JointReading(channel.signal, mean, spread, counted.count, last))
    return sorted(found, key=lambda reading: list(joints).index(reading.name))


def objections(readings: Iterable[JointReading], limit_rad: float) -> list[str]:
    """Return why these readings must not become zeros, one sentence each; empty if they may."""
    found: list[str] = []
    for name, mean, spread, taken, _ in readings:
        if taken < LEAST_READINGS:
            found.append(
                f"{name} was read {taken} times only, not {LEAST_READINGS}: measure for longer, or "
                "its board is silent"
            )
        elif spread > STILL_RAD:
            found.append(
                f"{name} is not still: it moved by {degrees(spread):.1f} deg, "
                f"at most {degrees(STILL_RAD):g} deg is allowed"
            )
        elif abs(mean) > limit_rad:
            found.append(
                f"{name} shows {degrees(mean):+.1f} deg, more than {degrees(limit_rad):g} deg from "
                "zero: it is not straight, or its magnet has slipped and must be turned back"
            )
        elif spread == 0.0:
            found.append(f"{name} shows exactly the same all the time: is its sensor connected?")
    return found

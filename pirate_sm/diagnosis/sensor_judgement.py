"""Finds what is wrong with the sensors of one board."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import degrees, hypot, radians

from pirate_sm.diagnosis.facts import BoardFact, ChannelFact, Subject
from pirate_sm.geometry.space import GRAVITY_M_S2
from pirate_sm.model.profile import Board, Channel

SAME = 20
"""More equal values in a row than chance allows: an angle flickers by a count."""


AT_END_RAD = radians(3)


GRAVITY_WITHIN = 2.5
"""m/s²; a robot at rest measures gravity alone."""


def judge_board(fact: BoardFact, subject: Subject) -> BoardFact:
    """Return the fact with the problems of each of the board's sensors."""
    board = next(each for each in subject.profile.boards if each.id == fact.id)
    channels = [
        replace(channel, trouble=(*channel.trouble, *_trouble(channel, known, fact, subject)))
        for channel, known in zip(fact.channels, board.channels, strict=True)
    ]
    _judge_gravity(channels, board)
    return replace(fact, channels=tuple(channels))


def _trouble(
    channel: ChannelFact, known: Channel, board: BoardFact, subject: Subject
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

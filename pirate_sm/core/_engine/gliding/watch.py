"""What must stay true of a run so that frames of the boards change nothing but signals."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers, often_replaced
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.environment import Surveyed
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._expressions.bytecode import Code


class Condition(NamedTuple):
    """A condition that a frame must leave as it is.

    Attributes:
        code: The condition.
        holds: Whether it is true now; otherwise it is false or unknown.
        boards: The boards after whose frames it is asked, as bits by their positions.
    """

    code: Code
    holds: bool
    boards: int


class SameDuty(NamedTuple):
    """A position loop that must give the duty that was sent last.

    Attributes:
        angle: Number index of the controlled angle.
        target_rad: The angle to reach.
        threshold_rad: Within this, the duty is 0; ``gain``, ``least_duty`` and ``limit`` give it
            elsewhere.
        resolution: Steps of the wire.
        sent: The duty that was sent last.
    """

    angle: int
    target_rad: float
    threshold_rad: float
    gain: float
    least_duty: float
    limit: float
    resolution: float
    sent: float


@often_replaced
class Watch(NamedTuple):
    """What a frame meets, and what it must leave as it is; else the engine must take it.

    A frame is quiet if its values are plausible, if it comes before the deadline and in time after
    the board's last one, if every condition of its board is as before, and if every loop gives
    the duty that was sent last. It changes nothing but
    :class:`~pirate_sm.core._engine.gliding.glided`.

    Attributes:
        robot: The robot.
        sensing: The signals before the frame.
        setpoints: Values in force per slot.
        latest: Values last sent, which may be in force already.
        asked: The array by which motions are judged, the last that was sent; empty before.
        origin: Signals when the wait began, for conditions on their changes; else empty.
        rules: The fault rules; the same object where they are the same again.
        conditions: The other conditions.
        duties: The loops.
        surveyed: What the survey of the pipe remembers, which is made again when it is due.
        held: The held parts by which it is made.
        in_bend: Whether a word has announced a bend that is not passed yet.
        frames_until_s: From when on no frame is quiet.
        wake_s: When the engine has asked to be called; what follows is what that is made of.
        deadline_s: When something else than the following two is due.
        word: The detector's valid word, if any; ``word_until_s``: until when.
        alarm_s: When the engine must be called although no event comes.
        listening_s: When silent boards are looked for next, which happens at intervals as long as
            all have reported; infinite where the engine must do it.
    """

    robot: RobotSpec
    sensing: Sensing
    setpoints: Numbers
    latest: Numbers
    asked: Numbers
    origin: Numbers
    rules: tuple[Condition, ...]
    conditions: tuple[Condition, ...]
    duties: tuple[SameDuty, ...]
    surveyed: Surveyed
    held: tuple[int, ...]
    in_bend: bool
    frames_until_s: float
    wake_s: float
    deadline_s: float
    word: str | None
    word_until_s: float
    alarm_s: float
    listening_s: float

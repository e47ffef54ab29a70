"""What is known of a robot's signals, and what of it a wait compares."""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing import plausibility
from pirate_sm.engine.sensing.sensor_memory import BoardMemory

Numbers = tuple[float, ...]


class MotorRequest(NamedTuple):
    """What the motors have been asked.

    Attributes:
        setpoints: The array last sent; empty before the first.
        since_s: When it was sent.
        driving: Whether a wheel is driven.
    """

    setpoints: Numbers = ()
    since_s: float = inf
    driving: bool = False


class Sensing(NamedTuple):
    """What is known of the world.

    Attributes:
        numbers: Signals in the order of the vocabulary, SI; NaN is unknown.
        heard_s: Per board when it last reported; -inf before it ever did.
        checked_s: When staleness was last looked at.
        stale: Boards whose signals have been forgotten.
        shares: Per wheel its share of the odometry when its board last reported; 0 when the wheel
            was not driven then. A wheel that has just been stopped still brings in what it
            rolled until then.
        angles: Per wheel what its sensor last showed, however long ago: what it has rolled while
            its board could not be heard is not lost with the frames.
        records: Per board what is remembered of its sensors, to know which values to believe.
        asked: What the motors have been asked, which tells what can move.
        loss: Share of the boards' reports that is lost, lately.
        told: In place of ``numbers``, what a script says that conditions see; empty without one.
            Changes of signals may follow, see :func:`with_changes`.
    """

    numbers: Numbers
    heard_s: tuple[float, ...]
    checked_s: float = 0.0
    stale: frozenset[int] = frozenset()
    shares: tuple[float, ...] = ()
    angles: tuple[float, ...] = ()
    records: tuple[BoardMemory, ...] = ()
    asked: MotorRequest = MotorRequest()
    loss: float = 0.0
    told: Numbers = ()

    @property
    def shown(self) -> Numbers:
        """Return what conditions of the mission see; position loops go by the boards alone."""
        return self.told[: len(self.numbers)] or self.numbers

    @property
    def doubted(self) -> frozenset[int]:
        """Return the number indexes that rest on a sensor whose last reading is not believed.

        The number is NaN, except in the first few readings, where it is the last believed value:
        the sensor may only have spiked.
        """
        return frozenset().union(*[record.doubted for record in self.records])


def with_changes(sensing: Sensing, origin: Numbers) -> Numbers:
    """Return the signals, and after them how much each has changed since a wait began.

    Args:
        sensing: What is known now.
        origin: The signals when the wait began. A change is unknown (NaN) where the signal is
            unknown now or was unknown then.
    """
    shown = sensing.shown
    if len(sensing.told) > len(shown):  # a script says the changes too
        return sensing.told
    return (*shown, *(now - then for now, then in zip(shown, origin, strict=True)))


def nothing_known(robot: RobotSpec, *, blind: bool = False) -> Sensing:
    """Return unknown signals; the odometer stands at zero unless nothing will ever be seen."""
    numbers = [nan] * len(robot.vocabulary.numbers)
    if robot.odometry >= 0 and not blind:
        numbers[robot.odometry] = 0.0
    count = len(robot.wheels)
    return Sensing(
        tuple(numbers),
        (-inf,) * len(robot.boards),
        shares=(0.0,) * count,
        angles=(nan,) * count,
        records=tuple(plausibility.unseen(board.watched) for board in robot.boards.values()),
    )

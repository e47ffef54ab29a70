"""Compare the motion that a sensor shows with the setpoint of its motor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import nan
from operator import itemgetter
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.sensing.plausibility_spec import (
    PlausibilitySpec,
    WatchedSpec,
    WatchSpec,
)
from pirate_sm.core._engine.sensing.sensor_memory import SensorMemory
from pirate_sm.core._engine.signals.evaluator import JUST_MOVED
from pirate_sm.core._model.events import FaultReport
from pirate_sm.core._model.fault_codes import BuiltInFault

Rows: TypeAlias = Sequence[Sequence[int]]


class MotionRows(NamedTuple):
    """The rows of a board's motions, see :mod:`pirate_sm.core._engine.signals.evaluator`.

    Attributes:
        kept: Runs rows, and returns whether all limits are kept; None if no motion is judged.
    """

    stuck: Rows = ()
    rest: Rows = ()
    kept: Callable[[Rows], bool] | None = None

    def repeated(self, cells: Sequence[float]) -> dict[int, tuple[float, float]]:
        """Return the constant reading of each sensor that shows one, and since when it does."""
        return {place: (cells[at], cells[at + 1]) for _, _, at, _, place in self.stuck}


NOTHING_COMPARED = MotionRows()


def after_motion(
    spec: PlausibilitySpec,
    watched: WatchedSpec,
    channels: Sequence[SensorMemory],
    motion: MotionRows,
    cells: list[float],
    now_s: float,
) -> tuple[Sequence[SensorMemory], list[FaultReport]]:
    """Return the sensors' memories after a comparison with their motors' setpoints, and faults.

    Args:
        spec: Thresholds of the robot.
        watched: The board's sensors.
        channels: Their memories, which are returned as they are where nothing is found.
        motion: The comparison.
        cells: All cells, with the signals as reported. What is remembered of motions is changed.
        now_s: When the frame was received.
    """
    found: list[tuple[int, FaultReport]] = []
    if motion.kept is None:
        return channels, []
    if not motion.kept(motion.stuck):
        for _, number, memory, _, place in motion.stuck:
            value, channel = cells[number], channels[place]
            stays = now_s - cells[memory + 1] >= spec.stuck_after_s
            if stays and value != channel.stuck:
                found.append((place, _stuck(spec, watched.sensors[place])))
                channel = channel._replace(
                    calm=False, good=value, good_s=now_s, wound=nan, stuck=value
                )
                channels = [*channels[:place], channel, *channels[place + 1 :]]
    believed = [
        (watch.number, cells[watch.number], channel.good)
        for watch, channel in zip(watched.sensors, channels, strict=True)
        if not channel.calm
    ]
    for number, _, good in believed:
        cells[number] = good
    if not motion.kept(motion.rest):
        for _, _, memory, _, place in motion.rest:
            if cells[memory + 6] == JUST_MOVED:
                cells[memory + 6] = 1.0
                found.append((place, _moved(watched.sensors[place])))
    for number, value, _ in believed:
        cells[number] = value
    return channels, [report for _, report in sorted(found, key=itemgetter(0))]


def _stuck(spec: PlausibilitySpec, watch: WatchSpec) -> FaultReport:
    message = (
        f"{watch.name} has shown the same for {spec.stuck_after_s:g} s while its motor is "
        "driven and bears no load: the sensor is stuck, or the motor gets no current"
    )
    return watch.report(BuiltInFault.SENSOR_STUCK, message)


def _moved(watch: WatchSpec) -> FaultReport:
    message = f"{watch.name} moves though nothing was asked of its motor"
    return watch.report(BuiltInFault.MOTION_UNASKED, message)

"""The order of a run: the options that were given, and what belongs to a backend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from pirate_sm.core.campaign import LineFaults
from pirate_sm.core.mission import Happening
from pirate_sm.core.options import GivenOptions
from pirate_sm.running.runtime.trigger_script import Firing


class PutBack(NamedTuple):
    """How a simulated robot stood when a recording was cut off.

    Attributes:
        places_m: Centre of each wheel.
        bends_rad: Angle of each driven joint of the body; ``torques_nm`` what its spring bears.
        values: The setpoints that hold it.
        at_s: Time since the run began.
        rolls_rad: The angle of the roll joint, and the rolls of the parts ahead and behind against
            the pipe where they are.
    """

    places_m: tuple[tuple[float, float, float], ...]
    bends_rad: tuple[float, ...]
    torques_nm: tuple[float, ...]
    values: tuple[float, ...]
    at_s: float
    rolls_rad: tuple[float, ...]


@dataclass(frozen=True)
class Order(GivenOptions):
    """The order of a run: its mission, the options that were given, and what belongs to a backend.

    Attributes:
        firings: Triggers that a trace fires instead of the first trigger of each wait.
        course: All events of a trace, in order.
        line: Faults of the line to the emulated bay; None: none.
        put_back: How a simulated robot stands that is put back; None: as its mission begins.
    """

    firings: tuple[Firing, ...] = ()
    course: tuple[Happening, ...] = ()
    line: LineFaults | None = None
    put_back: PutBack | None = None

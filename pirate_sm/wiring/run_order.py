"""The options of a run, as the user gave them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from pirate_sm.errors import Hint
from pirate_sm.model.fidelity import USUAL, Fidelity
from pirate_sm.model.trace_script import Happening
from pirate_sm.model.variations import LineFaults
from pirate_sm.runtime.trigger_script import Firing

USE_TRACE = Hint(": use --backend trace", ": use backend='trace'")


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
class Order:
    """The options of a run, as the user gave them.

    Attributes:
        mission: Name of a shipped mission, or the path of a file.
        backend: Name of a backend, as ``pirate list backends`` shows them.
        robot: Name or path, instead of the mission's own; likewise ``pipe``.
        settings: Values of parameters, as text.
        start_phase: The phase to begin with, instead of the mission's own.
        states: The robot's states at the start, by region, instead of the mission's own.
        seed: Seed of all random numbers.
        start_jitter_m: How far a simulated robot may start from its position; likewise
            ``diameter_jitter_m`` for the pipe, and ``friction_jitter`` as a share.
        fidelity: How finely the kinematic simulator computes; ``fast`` has half the iterations.
        defects: Defects of the simulated robot, as text with their numbers.
        twin: File with numbers of the simulated robot, instead of its profile's.
        fitted: File with numbers of the robot's motors, by which it is judged on every backend.
        firings: Triggers that a trace fires instead of the first trigger of each wait.
        course: All events of a trace, in order.
        detector: Name of the detector with its argument, ``odometry`` or ``socket:ADDRESS``;
            None for the backend's default.
        also: A second detector, whose words are logged only.
        ruler: Whether a simulated ruler measures the speed of the robot from outside.
        start_at_m: Position of the first wheel at the start of odometry, instead of the pipe's.
        line: Faults of the line to the emulated bay; None: none.
        port: Port of the real robot, a device or a URL of pyserial; ``baud`` instead of the
            profile's rate.
        guard_for_s: How long a guardian goes on without the runner if the robot does not confirm
            its stop; None: the default.
        calibration: Whether the joint zeros of the real robot are subtracted, if it has any.
        check: Whether a mission with a certain error is refused.
        view: Whether the backend's own viewer shows the run.
        put_back: How a simulated robot stands that is put back; None: as its mission begins.
        panel: Name or file of a control panel, with its device as ``NAME:DEVICE``; None: no panel.
    """

    mission: str
    backend: str = "sim"
    robot: str | None = None
    pipe: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    start_phase: str | None = None
    states: Mapping[str, str] | None = None
    seed: int = 0
    start_jitter_m: float = 0.0
    friction_jitter: float = 0.0
    diameter_jitter_m: float = 0.0
    fidelity: Fidelity = USUAL
    defects: tuple[str, ...] = ()
    twin: str | None = None
    fitted: str | None = None
    firings: tuple[Firing, ...] = ()
    course: tuple[Happening, ...] = ()
    detector: str | None = None
    also: str | None = None
    ruler: bool = False
    start_at_m: float | None = None
    line: LineFaults | None = None
    port: str | None = None
    baud: int | None = None
    guard_for_s: float | None = None
    calibration: bool = True
    check: bool = False
    view: bool = False
    panel: str | None = None
    put_back: PutBack | None = None

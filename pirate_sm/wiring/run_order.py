"""What somebody wants to be run: every option of a run, as the user gave it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pirate_sm.model.trace_script import Happening
from pirate_sm.runtime.trigger_script import Firing


@dataclass(frozen=True)
class Order:
    """What somebody wants to be run, in their own words.

    Attributes:
        mission: Name of a shipped mission, or the path of a file.
        backend: Name of a backend, as ``pirate list backends`` shows them.
        robot: Name or path, in place of the mission's own; likewise ``pipe``.
        settings: Values of parameters, as text.
        start_phase: The phase to begin with, in place of the mission's own.
        states: State names by region that the robot is in, in place of the mission's own.
        seed: Of everything random.
        start_jitter_m: How far a simulated robot may start from its place; likewise
            ``diameter_jitter_m`` of the pipe, and ``friction_jitter`` as a share.
        defects: Known defects that the simulated robot has.
        firings: What a trace fires instead of the first trigger of each wait.
        course: What happens in a trace, everything and in order.
        detector: Name of the detector with its argument, ``odometry`` or ``socket:ADDRESS``;
            None for what is usual on the backend.
        start_at_m: Where odometry takes the first wheel to begin, in place of the pipe's own.
        port: Where the real robot is, a device or a URL of pyserial; ``baud`` in place of the
            robot's own rate.
        guard_for_s: How long a guardian goes on without us if the robot does not confirm its stop;
            None: the usual time.
        calibration: Whether the joint zeros of the real robot are subtracted, where it has any.
        check: Whether a mission with something certainly wrong is refused.
        view: Whether the backend's own viewer shows the run.
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
    defects: tuple[str, ...] = ()
    firings: tuple[Firing, ...] = ()
    course: tuple[Happening, ...] = ()
    detector: str | None = None
    start_at_m: float | None = None
    port: str | None = None
    baud: int | None = None
    guard_for_s: float | None = None
    calibration: bool = True
    check: bool = False
    view: bool = False

"""Which detector somebody wants, in their own words, and what that makes of a run.

What a detector's factory receives (:class:`Asked`) and returns (:class:`Detecting`) stands here,
and the registry of detectors with ours at its end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

from pirate_sm.companion import Companion
from pirate_sm.detectors.odometry_detector import Odometry
from pirate_sm.detectors.operator_keys import offer
from pirate_sm.detectors.sim_detector import TruePlaces
from pirate_sm.detectors.socket_detector import OutsideWords
from pirate_sm.detectors.socket_listener import read_address
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.errors import Hint, UsageError
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile
from pirate_sm.model.true_position import Truth
from pirate_sm.registry import Plugin, Registry


class Places(NamedTuple):
    """What a backend knows of true places along the pipe, m.

    Attributes:
        bends_m: Where the bends are.
        wheels_m: Returns where each wheel is now.
    """

    bends_m: Sequence[float]
    wheels_m: Callable[[], Sequence[float]]


@dataclass(frozen=True)
class Asked:
    """What a detector is made for.

    Attributes:
        profile: The robot.
        robot: The same, as the engine knows it.
        pipe: Where it is, where that is known.
        first_wheel_m: Where its first wheel begins, in place of the pipe's own.
        places: What the backend knows of true places; None where it knows nothing.
        seed: Of the detector's errors.
        by_name: Whether somebody has asked for this detector; else it is what is usual.
        argument: What stands after a colon behind the name; None without a colon.
    """

    profile: Profile
    robot: RobotSpec
    pipe: Pipe | None
    first_wheel_m: float | None = None
    places: Places | None = None
    seed: int = 0
    by_name: bool = True
    argument: str | None = None


class Detecting(NamedTuple):
    """Who says the words of a run.

    Attributes:
        kind: The detector's name; ``none``: nobody says any. For ``operator`` whoever has the
            keyboard makes the companion.
        companions: Who stands beside the mission for it; what can be entered must be.
        notices: What a person should know.
        reckoned: Where the detector takes the robot to be, where it does.
    """

    kind: str
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    reckoned: Callable[[], Truth | None] | None = None


class MakeDetector(Protocol):
    """What the entry point of a detector makes it with; see ``docs/extending.md``."""

    def __call__(self, asked: Asked) -> Detecting:
        """Return the detector; nothing has been opened.

        Raises:
            UsageError: It cannot do what is asked.
        """
        ...


def detecting(text: str | None, usual: str, asked: Asked) -> Detecting:
    """Return who says the words of a run; nothing has been opened.

    Args:
        text: What was wished, a name or ``NAME:ARGUMENT``; None for what is usual.
        usual: The backend's own detector.
        asked: What it is made for.

    Raises:
        UsageError: The wish cannot be met.
    """
    name, colon, rest = (usual if text is None else text).partition(":")
    make = DETECTORS.find(name)
    if asked.first_wheel_m is not None and name != "odometry":
        raise UsageError(
            "only the detector odometry takes a place where it begins to count",
            hint=Hint(
                ": --start-at goes with --detector odometry",
                ": start_at_m goes with detector='odometry'",
            ),
        )
    argument = rest if colon else None
    return make(replace(asked, by_name=text is not None, argument=argument))


def _refuse_argument(name: str, asked: Asked) -> None:
    if asked.argument is not None:
        raise UsageError(f"detector {name}:{asked.argument}: {name} takes no argument")


def _true_places(asked: Asked) -> Detecting:
    _refuse_argument("sim", asked)
    if asked.places is None:
        raise UsageError("detector sim: only the backend sim knows where the robot really is")
    bends_m, wheels_m = asked.places
    sees = TruePlaces(asked.profile, asked.robot, bends_m, wheels_m, asked.seed)
    return Detecting("sim", (sees,))


def _odometry(asked: Asked) -> Detecting:
    _refuse_argument("odometry", asked)
    if asked.pipe is None and not asked.by_name:
        return Detecting("none", (), ("detector: none, the mission names no pipe",))
    if asked.pipe is None:
        hint = Hint(": give it with --pipe", ": give it with pipe='NAME'")
        raise UsageError("the detector odometry needs to know the pipe", hint=hint)
    odometry = Odometry(asked.profile, asked.robot, asked.pipe, asked.first_wheel_m)
    place = f"{odometry.first_wheel_m * 1000:.4g} mm"
    notice = f"detector: odometry, counted from the first wheel at {place} of the pipe"
    return Detecting("odometry", (odometry,), (notice,), odometry.truth)


def _operator(asked: Asked) -> Detecting:
    _refuse_argument("operator", asked)
    notice = f"detector: the keys {offer(asked.robot.detector_words)}"
    return Detecting("operator", (), (notice,))


def _socket(asked: Asked) -> Detecting:
    address = read_address(asked.argument or "")
    socket = OutsideWords(address, asked.robot.detector_words, asked.profile.detector.valid_for)
    return Detecting("socket", (socket,), (f"detector: programs that write to {socket.address}",))


SIM: Plugin[MakeDetector] = Plugin("the simulator, which knows where the robot is", _true_places)
ODOMETRY: Plugin[MakeDetector] = Plugin("dead reckoning by wheels and joints", _odometry)
OPERATOR: Plugin[MakeDetector] = Plugin("a person with a key for each word", _operator)
SOCKET: Plugin[MakeDetector] = Plugin(
    "programs that write to a socket: socket:HOST:PORT or socket:/PATH", _socket
)

DETECTORS: Registry[MakeDetector] = Registry(
    "detector",
    "pirate_sm.detectors",
    {name: f"{__name__}:{name.upper()}" for name in ("sim", "odometry", "operator", "socket")},
    returns=Detecting,
)

"""The registry of detectors, and the choice of the one that a user asks for.

A detector's factory receives :class:`Asked` and returns :class:`Detecting`. The package's own
detectors are at the end.
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
    """What a backend knows of true positions along the pipe, m.

    Attributes:
        bends_m: Positions of the bends.
        wheels_m: Returns the present position of each wheel.
    """

    bends_m: Sequence[float]
    wheels_m: Callable[[], Sequence[float]]


@dataclass(frozen=True)
class Asked:
    """What a detector is made for.

    Attributes:
        profile: The robot's profile.
        robot: The robot as the engine knows it.
        pipe: The pipe, if it is known.
        first_wheel_m: Position of the first wheel at the start, in place of the pipe's.
        places: The backend's true positions; None if it knows none.
        seed: Seed of the detector's errors.
        by_name: Whether the user chose this detector; otherwise it is the default.
        argument: The text after the colon in the name; None without a colon.
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
    """The detector of a run.

    Attributes:
        kind: The detector's name; ``none``: there is no detector. For ``operator`` the owner of the
            keyboard makes the companion.
        companions: Its companions; a context manager among them must be entered.
        notices: Notices for the user.
        reckoned: Returns the estimated position, if the detector has one.
    """

    kind: str
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    reckoned: Callable[[], Truth | None] | None = None


class MakeDetector(Protocol):
    """The factory in a detector's entry point; see ``docs/extending.md``."""

    def __call__(self, asked: Asked) -> Detecting:
        """Return the detector without opening anything.

        Raises:
            UsageError: The detector cannot be made for this run.
        """
        ...


def detecting(text: str | None, usual: str, asked: Asked) -> Detecting:
    """Return the detector of a run, without opening anything.

    Args:
        text: The user's choice, a name or ``NAME:ARGUMENT``; None for the default.
        usual: The default, which is the backend's own detector.
        asked: What it is made for.

    Raises:
        UsageError: The detector does not exist or cannot be made.
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

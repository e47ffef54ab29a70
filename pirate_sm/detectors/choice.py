"""Which detector somebody wants, in their own words, and what that makes of a run."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.detectors.keys import offer
from pirate_sm.detectors.listener import Address, read_address
from pirate_sm.detectors.odometry import Odometry
from pirate_sm.detectors.outside import OutsideWords
from pirate_sm.detectors.true_places import TruePlaces
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile
from pirate_sm.spelling import nearest, one_of

Kind: TypeAlias = Literal["sim", "odometry", "operator", "socket", "none"]

_NAMED: dict[str, Kind] = {"sim": "sim", "odometry": "odometry", "operator": "operator"}


class Choice(NamedTuple):
    """A detector; ``address`` is where a socket listens."""

    kind: Kind
    address: Address | None = None


class Detecting(NamedTuple):
    """Who says the words of a run.

    Attributes:
        kind: ``sim``: the simulator; whoever has it makes the companion, as whoever has the
            keyboard does for ``operator``. ``none``: nobody.
        companions: Who stands beside the mission for it; what can be entered must be.
        notices: What a person should know.
    """

    kind: Kind
    companions: tuple[Odometry | OutsideWords | TruePlaces, ...] = ()
    notices: tuple[str, ...] = ()


def read_choice(text: str) -> Choice:
    """The detector that a text names.

    Raises:
        UsageError: It names none.
    """
    name, colon, rest = text.partition(":")
    if name == "socket":
        return Choice("socket", read_address(rest))
    if name not in _NAMED or colon:
        known = [*_NAMED, "socket:HOST:PORT", "socket:/PATH"]
        close = nearest(name, _NAMED)
        hint = f"did you mean '{close}'?" if close else f"expected {one_of(known)}"
        raise UsageError(f"--detector {text}: there is no such detector: {hint}")
    return Choice(_NAMED[name])


def detecting(
    text: str | None,
    *,
    usual: Kind,
    profile: Profile,
    robot: RobotSpec,
    pipe: Pipe | None,
    first_wheel_m: float | None = None,
) -> Detecting:
    """Who says the words of a run; nothing has been opened.

    Args:
        text: What was wished; None for what is usual.
        usual: The backend's own detector.
        profile: The robot.
        robot: The same, as the engine knows it.
        pipe: Where it is, where that is known.
        first_wheel_m: Where its first wheel begins, in place of the pipe's own.

    Raises:
        UsageError: The wish cannot be met.
    """
    choice = read_choice(text) if text is not None else Choice(usual)
    if first_wheel_m is not None and choice.kind != "odometry":
        raise UsageError("--start-at is where --detector odometry begins to count")
    if choice.kind == "sim" and usual != "sim":
        raise UsageError("--detector sim: only --backend sim knows where the robot really is")
    if choice.kind == "odometry":
        if pipe is None and text is None:
            return Detecting("none", (), ("detector: none, the mission names no pipe",))
        if pipe is None:
            raise UsageError("--detector odometry needs to know the pipe: give it with --pipe")
        return _reckoning(Odometry(profile, robot, pipe, first_wheel_m))
    if choice.address is not None:
        socket = OutsideWords(choice.address, robot.detector_words, profile.detector.valid_for)
        notice = f"detector: programs that write to {socket.address}"
        return Detecting("socket", (socket,), (notice,))
    if choice.kind == "operator":
        return Detecting("operator", (), (f"detector: the keys {offer(robot.detector_words)}",))
    return Detecting(choice.kind)


def _reckoning(odometry: Odometry) -> Detecting:
    place = f"{odometry.first_wheel_m * 1000:.4g} mm"
    notice = f"detector: odometry, counted from the first wheel at {place} of the pipe"
    return Detecting("odometry", (odometry,), (notice,))

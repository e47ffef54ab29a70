"""The registry of detectors, and the choice of the one that a user asks for, or of a second one.

A detector's factory receives :class:`Asked` and returns :class:`Detecting`. What goes wrong in a
detector of another package is said to be its own. The package's own detectors are at the end.
"""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import wraps
from math import inf
from typing import Any, NamedTuple, Protocol, Self, get_args

from pirate_sm.core.companion import Companion, Counting, Onlooker, entered
from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import DetectorError, Hint, PirateError, UsageError
from pirate_sm.core.events import DetectorWord, Event, FaultReport, Truth
from pirate_sm.core.geometry import Bend
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.registry import Plugin, Registry
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot import part_names
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.simple_detectors import SignalWords, TruePlaces, offer
from pirate_sm.robot.detectors.socket_detector import AcceptedLines, OutsideWords, read_address
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.robot.detectors.word_timing import words_of

# --- a second detector ----------------------------------------------------------------------------


class SecondDetector:
    """A companion that logs what another detector would report; a repeated word is logged once.

    Args:
        name: The detector's name.
        companion: A companion of the detector.
    """

    def __init__(self, name: str, companion: Companion) -> None:
        self._name = name
        self._companion = companion
        self._until_s: dict[str, float] = {}
        self._entered = ExitStack()

    @property
    def due_s(self) -> float:
        """Return the mission time of its next call."""
        return self._companion.due_s

    @property
    def listening(self) -> bool:
        """Return whether the detector waits for a person or another program."""
        return self._companion.listening

    def __enter__(self) -> Self:
        """Open the detector."""
        self._entered.enter_context(entered([self._companion]))
        return self

    def __exit__(self, *_: object) -> None:
        """Close the detector."""
        self._entered.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Process the effects of the last step."""
        self._companion.react(effects, now_s)

    def restart(self, robot: RobotSpec) -> None:
        """Begin again for another mission."""
        if isinstance(self._companion, Counting):
            self._companion.restart(robot)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the detector's own messages, and its words and faults since the last look."""
        looked = self._companion.look(state, now_s) if isinstance(self._companion, Onlooker) else ()
        return (*looked, *self._logs(self._companion.speak(now_s), now_s))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing: the detector has been asked in ``look``."""
        return ()

    def _logs(self, events: Sequence[Event], now_s: float) -> Iterator[Log]:
        """Yield a message for each fault, and for a word that is not valid already."""
        for event in events:
            if isinstance(event, FaultReport):
                yield Log("warning", f"also {self._name}: {event.message}")
            elif isinstance(event, DetectorWord):
                if now_s > self._until_s.get(event.word, -inf):
                    yield Log("info", f"also {self._name}: {event.word}")
                self._until_s = {event.word: now_s + event.valid_for_s}


# --- detectors of other packages ------------------------------------------------------------------


_MOST_WORDS_OF_A_MOMENT = 1_000
_MOMENT_S = 1e-4
"""A detector that speaks more often than that within this mission time lets time stand still."""

_OPTIONAL = ("look", "restart", "follow", "word_watch", "relieve")
"""What only some companions can do: see :mod:`pirate_sm.core.companion`."""


class OfOthers:
    """A companion of another package, whose faults carry its name.

    It can do what the other one can.

    Args:
        whose: The detector, its package and its entry point.
        companion: The companion.
    """

    def __init__(self, whose: str, companion: Companion) -> None:
        self._whose = whose
        self._companion = companion
        self._entered = ExitStack()
        self._moment_s, self._left = -inf, _MOST_WORDS_OF_A_MOMENT
        for name in _OPTIONAL:
            if hasattr(companion, name):
                setattr(self, name, guarded(whose, name, getattr(companion, name)))

    @property
    def due_s(self) -> float:
        """Return the mission time of its next call."""
        with _blaming(self._whose, "due_s"):
            return float(self._companion.due_s)

    @property
    def listening(self) -> bool:
        """Return whether it waits for a person."""
        with _blaming(self._whose, "listening"):
            return bool(self._companion.listening)

    def __enter__(self) -> Self:
        """Enter the companion if it is a context manager; what it refuses is said in its words."""
        if isinstance(self._companion, AbstractContextManager):
            with _blaming(self._whose, "__enter__", lets_refuse=True):
                self._entered.enter_context(self._companion)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the companion."""
        with _blaming(self._whose, "__exit__"):
            self._entered.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Process the effects of the last step."""
        with _blaming(self._whose, "react"):
            self._companion.react(effects, now_s)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the events due now.

        Raises:
            DetectorError: It raises, returns anything else, or does not move ``due_s`` on.
        """
        with _blaming(self._whose, "speak"):
            said = tuple(self._companion.speak(now_s))
            for each in said:
                if not isinstance(each, get_args(Event)):
                    raise TypeError(f"{each!r} is no event")
        self._keep_time(now_s)
        return said

    def _keep_time(self, now_s: float) -> None:
        if now_s > self._moment_s + _MOMENT_S:
            self._moment_s, self._left = now_s, _MOST_WORDS_OF_A_MOMENT
        self._left -= 1
        if self._left < 0:
            due = f"due_s is {self.due_s:g} s at {now_s:g} s of mission time"
            raise DetectorError(
                f"{self._whose} lets time stand still: {due}; speak must move it on"
            )


def guarded(whose: str, what: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function so that what it raises is a ``DetectorError``."""

    @wraps(function)
    def called(*arguments: Any, **options: Any) -> Any:
        with _blaming(whose, what):
            return function(*arguments, **options)

    return called


@contextmanager
def _blaming(whose: str, what: str, *, lets_refuse: bool = False) -> Iterator[None]:
    """Turn what is raised into a ``DetectorError``; ``lets_refuse``: not our own errors."""
    try:
        yield
    except (Exception, SystemExit) as error:
        if isinstance(error, DetectorError) or (lets_refuse and isinstance(error, PirateError)):
            raise
        fault = f"{type(error).__name__}: {error}"
        raise DetectorError(f"{whose} fails in {what} with {fault}") from error


# --- the choice -----------------------------------------------------------------------------------


TOKEN_VARIABLE = "PIRATE_SM_TOKEN"
"""Environment variable with the token of programs that connect over TCP."""

_TOKEN_BYTES = 12

_COUNTING = ("odometry", "vision")
"""The detectors that count, from a place that the user may name."""

_OF_BENDS = ("sim", *_COUNTING)
"""The detectors that say where the robot is to a bend. A person or a program may say any word."""


class Places(NamedTuple):
    """What a backend knows of true positions along the pipe, m.

    Attributes:
        bends: The bends.
        wheels_m: Returns the present position of each wheel.
    """

    bends: Sequence[Bend]
    wheels_m: Callable[[], Sequence[float]]


@dataclass(frozen=True)
class Asked:
    """What a detector is made for.

    Attributes:
        profile: The robot's profile.
        robot: The robot as the engine knows it.
        pipe: The pipe, if it is known.
        first_wheel_m: Position of the first wheel at the start, instead of the pipe's.
        places: The backend's true positions; None if it knows none.
        wheels: Returns the true position of each wheel in the plane of the pipe, m.
        seed: Seed of the detector's errors.
        by_name: Whether the user chose this detector; otherwise it is the default.
        argument: The text after the colon in the name; None without a colon.
    """

    profile: Profile
    robot: RobotSpec
    pipe: Pipe | None
    first_wheel_m: float | None = None
    places: Places | None = None
    wheels: Callable[[], Sequence[tuple[float, float]]] | None = None
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
        camera: Returns what a recording keeps of its camera, if it has one.
    """

    kind: str
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    reckoned: Callable[[], Truth | None] | None = None
    camera: Callable[[], CameraView | None] | None = None


NOBODY = Detecting("none")
"""No detector."""


class MakeDetector(Protocol):
    """The factory in a detector's entry point; see ``docs/extending.md``."""

    def __call__(self, asked: Asked) -> Detecting:
        """Return the detector without opening anything.

        Raises:
            UsageError: The detector cannot be made for this run.
        """


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
    if asked.first_wheel_m is not None and not counts(name):
        raise UsageError(
            "only the detectors odometry and vision take a place where they begin to count",
            hint=Hint(
                ": --start-at goes with --detector odometry or vision:CAMERA",
                ": start_at_m goes with detector='odometry' or 'vision:CAMERA'",
            ),
        )
    argument = rest if colon else None
    return make(replace(asked, by_name=text is not None, argument=argument))


def counts(text: str) -> bool:
    """Return whether the detector of this text counts from a place that the user may name."""
    return text.partition(":")[0] in _COUNTING


def speaks_of_bends(text: str | None) -> bool:
    """Return whether the detector of this text says where the robot is to a bend of the pipe.

    Those that backends use where nobody has chosen one (None) do.
    """
    return text is None or text.partition(":")[0] in _OF_BENDS


def _refuse_argument(name: str, asked: Asked) -> None:
    if asked.argument is not None:
        raise UsageError(f"detector {name}:{asked.argument}: {name} takes no argument")


def _true_places(asked: Asked) -> Detecting:
    _refuse_argument("sim", asked)
    if asked.places is None:
        raise UsageError("detector sim: only the backend sim knows where the robot really is")
    if not words_of(asked.profile):
        return _without_points("sim", asked)
    bends, wheels_m = asked.places
    sees = TruePlaces(asked.profile, asked.robot, bends, wheels_m, asked.seed)
    return Detecting("sim", (sees,))


def _odometry(asked: Asked) -> Detecting:
    _refuse_argument("odometry", asked)
    if asked.pipe is None and not asked.by_name:
        return Detecting("none", (), ("detector: none, the mission names no pipe",))
    if asked.pipe is None:
        hint = Hint(": give it with --pipe", ": give it with pipe='NAME'")
        raise UsageError("the detector odometry needs to know the pipe", hint=hint)
    if not words_of(asked.profile):
        return _without_points("odometry", asked)
    odometry = Odometry(asked.profile, asked.robot, asked.pipe, asked.first_wheel_m)
    place = f"{odometry.first_wheel_m * 1000:.4g} mm"
    notice = f"detector: odometry, counted from the first wheel at {place} of the pipe"
    return Detecting("odometry", (odometry,), (notice,), odometry.truth)


def _without_points(name: str, asked: Asked) -> Detecting:
    """Return no detector, for a robot none of whose words begins at a point of the pipe.

    Raises:
        UsageError: The user asked for one.
    """
    why = "no word of the profile has points, `forward` and `backward`"
    if asked.by_name:
        raise UsageError(f"the detector {name}: {why}")
    return Detecting("none", (), (f"detector: none, {why}",))


def _operator(asked: Asked) -> Detecting:
    _refuse_argument("operator", asked)
    notice = f"detector: the keys {offer(asked.robot.detector_words)}"
    return Detecting("operator", (), (notice,))


def _signals(asked: Asked) -> Detecting:
    """Return the detector of words with conditions; an argument also lets numbers in."""
    settings, robot = asked.profile.detector, asked.robot
    if not robot.word_conditions:
        message = f"the detector signals: no word of {robot.name} has a condition"
        raise UsageError(f"{message}; give one to a word of its profile: `when: SIGNAL < 80 mm`")
    said = [each.word for each in robot.word_conditions]
    notices = [f"detector: conditions on signals say {', '.join(said)}"]
    if never := [word for word in robot.detector_words if word not in said]:
        notices.append(f"detector: nothing says {', '.join(never)}, without a condition")
    words = SignalWords(robot, settings.valid_for)
    if asked.argument is None:
        return Detecting("signals", (words,), tuple(notices))
    numbers, how = _outside(asked, AcceptedLines((), signals=_valid_for(asked.profile)))
    return Detecting("signals", (numbers, words), (*notices, f"numbers from programs {how}"))


def _socket(asked: Asked) -> Detecting:
    words, valid_for_s = asked.robot.detector_words, asked.profile.detector.valid_for
    accepted = AcceptedLines(words, valid_for_s, _valid_for(asked.profile))
    socket, how = _outside(asked, accepted)
    return Detecting("socket", (socket,), (f"detector: programs {how}",))


def _valid_for(profile: Profile) -> dict[str, float]:
    """Return how long the value of each outside signal counts, s."""
    return {name: signal.valid_for for name, signal in profile.outside.items()}


def _outside(asked: Asked, accepted: AcceptedLines) -> tuple[OutsideWords, str]:
    """Return the door for other programs, and how they use it."""
    address = read_address(asked.argument)
    if address.path:
        return OutsideWords(address, accepted), f"that write to {address}"
    token = os.environ.get(TOKEN_VARIABLE, "")
    shown = f"with the token in {TOKEN_VARIABLE}"
    if token != token.encode(errors="replace").decode():
        raise UsageError(f"{TOKEN_VARIABLE} holds bytes that are not UTF-8 text")
    if not token:
        token = secrets.token_urlsafe(_TOKEN_BYTES)
        shown = json.dumps({"token": token})
    how = f"that write to {address}, first a line {shown}"
    return OutsideWords(address, accepted, token), how


def _guards(whose: str, made: Detecting) -> Detecting:
    """Return the detector of another package so that its faults are said to be its own."""
    return made._replace(
        companions=tuple(OfOthers(whose, each) for each in made.companions),
        reckoned=made.reckoned and guarded(whose, "reckoned", made.reckoned),
        camera=made.camera and guarded(whose, "camera", made.camera),
    )


SIM: Plugin[MakeDetector] = Plugin(part_names.DETECTORS["sim"], _true_places)
ODOMETRY: Plugin[MakeDetector] = Plugin(part_names.DETECTORS["odometry"], _odometry)
SIGNALS: Plugin[MakeDetector] = Plugin(part_names.DETECTORS["signals"], _signals)
OPERATOR: Plugin[MakeDetector] = Plugin(part_names.DETECTORS["operator"], _operator)
SOCKET: Plugin[MakeDetector] = Plugin(part_names.DETECTORS[part_names.BY_SOCKET], _socket)

_ELSEWHERE = {part_names.BY_CAMERA: "pirate_sm.running.wiring.vision:DETECTOR"}

DETECTORS: Registry[MakeDetector] = Registry(
    "detector",
    part_names.DETECTOR_GROUP,
    {name: f"{__name__}:{name.upper()}" for name in part_names.DETECTORS} | _ELSEWHERE,
    returns=Detecting,
    guards=_guards,
)

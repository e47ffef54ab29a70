"""Messages for viewers: Foxglove's own message types, and flat topics that can be plotted.

Times, frames, scene, joint states and log have Foxglove's published types, so Foxglove, Lichtblick
and PlotJuggler need no set-up. The rest are plain numbers and words by name. All of it but the true
positions and the camera's messages can be made again from the engine's inputs.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from math import isfinite, isnan
from typing import Any, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.effects import Level
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import InSpace
from pirate_sm.core.expressions import EnumType
from pirate_sm.core.geometry import Place, drawn_walls
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import Body, Pipe, Profile, Straight
from pirate_sm.core.robot import USUAL, RobotSpec, confirmed_parts
from pirate_sm.robot.detectors.dead_reckoning import Reckoned, Reckoner
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.recording.format.engine_topics import DIALECT, rounded
from pirate_sm.running.recording.signal_names import signal_names, slot_names
from pirate_sm.running.recording.viewers.foxglove_scene import scene_message
from pirate_sm.running.recording.viewers.transforms import SpaceTransforms, Transforms, link_poses

# --- topics ---------------------------------------------------------------------------------------


NS_PER_S = 1_000_000_000
NUMBER = {"type": "number"}
WORD = {"type": "string"}


@dataclass(frozen=True, eq=False)
class ViewerChannel:
    """A topic for viewers."""

    topic: str
    schema_name: str
    schema: Mapping[str, Any]


Message = tuple[ViewerChannel, bytes]


def flat(topic: str, columns: Mapping[str, Any]) -> ViewerChannel:
    """Return a topic of plain columns."""
    name = f"pirate_sm{topic.replace('/', '.')}"
    schema = {"$schema": DIALECT, "title": name, "type": "object", "properties": dict(columns)}
    return ViewerChannel(topic, name, schema)


def foxglove(topic: str, name: str) -> ViewerChannel:
    """Return a topic of one of Foxglove's types; their schemas are next to this module."""
    title = f"foxglove.{name}"
    file = files("pirate_sm.running.recording.viewers") / "foxglove_schemas" / f"{title}.json"
    return ViewerChannel(topic, title, json.loads(file.read_text("utf-8")))


def stamp(time_ns: int) -> str:
    """Return the time as JSON in Foxglove's format."""
    seconds, rest = divmod(time_ns, NS_PER_S)
    return f'{{"sec":{seconds},"nsec":{rest}}}'


# --- a camera -------------------------------------------------------------------------------------


PICTURES = "/camera"
"""The topic with the camera's pictures."""


class CameraMessages:
    """Makes the messages of one run.

    Args:
        wheels: Names of the wheels.
    """

    def __init__(self, wheels: Sequence[str]) -> None:
        self._names = [f"{name}_m" for name in wheels]
        columns = (*self._names, "marks", "rms_px", "gray_spread", "age_s")
        self._seen = flat("/vision", dict.fromkeys(columns, NUMBER))
        self._pictures = foxglove(PICTURES, "CompressedImage")

    @property
    def channels(self) -> dict[str, ViewerChannel]:
        """Return the topics by their names."""
        return {channel.topic: channel for channel in (self._seen, self._pictures)}

    def of(self, at_s: float, time_ns: int, view: CameraView) -> Iterator[Message]:
        """Yield where the camera sees the wheels along the pipe, and its picture if there is one.

        Unknown numbers are left out.
        """
        sighting = view.sighting
        numbers = dict(zip(self._names, view.seen.places_m, strict=True))
        numbers |= {
            "marks": len(sighting.marks),
            "gray_spread": sighting.gray_spread,
            "age_s": at_s - sighting.captured_s,
        }
        if sighting.rms_px is not None:
            numbers["rms_px"] = sighting.rms_px
        known = {name: round(value, 6) for name, value in numbers.items() if isfinite(value)}
        yield self._seen, json.dumps(known).encode()
        if view.jpeg:
            yield self._pictures, self._picture(time_ns, view.jpeg)

    @staticmethod
    def _picture(time_ns: int, jpeg: bytes) -> bytes:
        data = b64encode(jpeg).decode()
        head = f'{{"timestamp":{stamp(time_ns)},"frame_id":"camera","format":"jpeg"'
        return f'{head},"data":"{data}"}}'.encode()


# --- the wheels -----------------------------------------------------------------------------------


_PATIENCE_S = 1.0
"""A joint without a value for this long is drawn straight, s."""

_LONGEST_M = 100.0


class WheelPlacing:
    """Follows a robot by its joints and its odometer, if its true position is not known.

    Args:
        profile: The robot's profile.
        robot: The robot as the engine knows it.
        pipe: The pipe; None: a straight one.
        first_wheel_m: Position of the first wheel along the pipe at the start; None: the pipe's.
    """

    def __init__(
        self, profile: Profile, robot: RobotSpec, pipe: Pipe | None, first_wheel_m: float | None
    ) -> None:
        pipe = pipe or _somewhere(profile.body)
        self._robot = robot
        joints = (*robot.body.joints, robot.body.roll)
        self._joints = [joint for joint in joints if joint >= 0]
        self._reckoner = Reckoner(robot.body, pipe.route(), robot.odometry)
        length_m = sum(robot.body.lengths_m)
        self._first_m = pipe.start_of(length_m) if first_wheel_m is None else first_wheel_m
        self._roll_rad = pipe.start.roll if pipe.start is not None else 0.0
        self._reckoned: Reckoned | None = None
        self._angles = dict.fromkeys(self._joints, 0.0)

    def look(self, state: EngineState, now_s: float) -> tuple[Place, ...] | None:
        """Return the current position of each wheel; None before its joints have values.

        A picture needs an angle, so an unknown one is drawn with its last value.
        """
        numbers, held = list(state.sensing.numbers), confirmed_parts(self._robot, state.robot)
        unknown = [joint for joint in self._joints if isnan(numbers[joint])]
        if unknown and self._reckoned is None and now_s < _PATIENCE_S:
            return None
        for joint in unknown:
            numbers[joint] = self._angles[joint]
        self._angles = {joint: numbers[joint] for joint in self._joints}
        if self._reckoned is None:
            self._reckoned = self._reckoner.begin(self._first_m, numbers, held, self._roll_rad)
        else:
            self._reckoned = self._reckoner.look(self._reckoned, numbers, held)
        return self._reckoned.points


def _somewhere(body: Body) -> Pipe:
    """Return a straight pipe just wide enough for the robot, if the pipe is unknown."""
    straight = Straight(straight=_LONGEST_M)
    return Pipe(diameter=2.5 * body.wheel_radius, segments=(straight,))


# --- a run ----------------------------------------------------------------------------------------


LEVELS: dict[Level, int] = {"info": 2, "warning": 3, "error": 4}
"""Level numbers of ``foxglove.Log``."""

PLACES = "/places"
"""The topic with the position of each wheel."""


class ViewerSnapshot(NamedTuple):
    """The present state of a run.

    Attributes:
        state: The engine's state.
        numbers: All signals in the order of the vocabulary, SI.
        wheels: Positions of the wheels in the plane of the pipe, m, if known or estimated.
        known: Whether they are the true positions.
        space: What they leave out of a robot in space, if known.
        camera: What the detector's camera sees, if there is one.
        rolls_rad: The rolls of a robot in a plane, as in
            :class:`~pirate_sm.running.recording.format.engine_topics.Placed`.
    """

    state: EngineState
    numbers: tuple[float, ...]
    wheels: tuple[Place, ...] | None
    known: bool
    camera: CameraView | None = None
    space: InSpace | None = None
    rolls_rad: tuple[float, ...] = ()


class ViewerMessages:
    """Makes messages for viewers of one run.

    Args:
        loaded: The mission.
        first_wheel_m: Position of the first wheel along the pipe at the start; None: the pipe's.
    """

    def __init__(self, loaded: LoadedMission, first_wheel_m: float | None) -> None:
        robot, profile = loaded.robot, loaded.loaded_robot.profile
        self._loaded, self._body = loaded, profile.body
        self._numbers = robot.vocabulary.numbers
        signals = signal_names(robot)
        self._signals = _gaps(signals)
        self._slots = slot_names(robot)
        self._placing = WheelPlacing(profile, robot, loaded.pipe, first_wheel_m)
        self._transforms = Transforms(self._body)
        self._joints = _joints(loaded)
        self._state: dict[str, Any] = {"phase": "", "detected": "", "control": USUAL}
        wheels = [wheel.name for wheel in self._body.wheels]
        coordinates = [f"{name}_{axis}_m" for name in wheels for axis in "xy"]
        self._coordinates = _gaps(coordinates)
        pipe = loaded.pipe
        route = pipe.route() if pipe is not None else None
        in_space = route is not None and route.section == "round"
        self._in_space = SpaceTransforms(self._body, route) if route and in_space else None
        # Reckoned places are drawn in the plane of the drawing.
        self._reckons = route is None or bool(drawn_walls(route))
        beyond = columns_in_space(wheels) if in_space else ROLLS
        self._beyond = _gaps(beyond)
        self._camera = CameraMessages(wheels)
        self._codes = _state_codes(robot)
        self._tf = foxglove("/tf", "FrameTransforms")
        self._scene = foxglove("/scene", "SceneUpdate")
        self._joint_states = foxglove("/joint_states", "JointStates")
        self._log = foxglove("/log", "Log")
        self._signal_channel = flat("/signals", dict.fromkeys(signals, NUMBER))
        self._setpoints = flat("/setpoints", dict.fromkeys(self._slots, NUMBER))
        places = {"known": {"type": "boolean"}, **dict.fromkeys((*coordinates, *beyond), NUMBER)}
        self._places = flat(PLACES, places)
        words = ("phase", "detected", *robot.regions, "unconfirmed", "control")
        codes = {
            _code_name(region): {"type": "integer", "description": _listed(names)}
            for region, names in self._codes.items()
        }
        self._states = flat("/state", {**dict.fromkeys(words, WORD), **codes})

    def scene(self, time_ns: int) -> Message:
        """Return the message that draws the robot and its pipe."""
        return self._scene, scene_message(stamp(time_ns), self._body, self._loaded.pipe)

    def sample(self, at_s: float, time_ns: int, it: ViewerSnapshot) -> Iterator[Message]:
        """Yield the messages with all positions at this time."""
        now = stamp(time_ns)
        shown = it.numbers
        numbers = dict(zip(self._numbers, shown, strict=True))
        points = it.wheels
        if points is None and self._reckons:
            points = self._placing.look(it.state, at_s)
        if points is not None:
            points = rounded(points)
            yield self._tf, self._frames(now, points, it.space, numbers)
            known = '"known":true' if it.known else '"known":false'
            values = tuple(value for point in points for value in point)
            more = values_in_space(it.space) if it.space else it.rolls_rad
            beyond = _filled(self._beyond, more) if more else ()
            yield self._places, _object(known, *_filled(self._coordinates, values), *beyond)
        if it.camera is not None:
            yield from self._camera.of(at_s, time_ns, it.camera)
        yield self._joint_states, self._joint_message(now, shown)
        yield self._signal_channel, _object(*_filled(self._signals, shown))
        control = self._loaded.robot.control_name(it.state.robot.control)
        if control != self._state["control"]:
            self._state["control"] = control
            yield self._states, _json(self._state)

    def _frames(
        self, now: str, points: Sequence[Place], space: InSpace | None, numbers: Mapping[str, float]
    ) -> bytes:
        """Return the message with the frames of all parts."""
        if self._in_space is None or space is None:
            return self._transforms.message(now, link_poses(points), numbers)
        in_space = [(x, y, z) for (x, y), z in zip(points, space.z_m, strict=True)]
        return self._in_space.message(now, in_space, space, numbers)

    def of_effects(self, time_ns: int, effects: Sequence[fx.Effect]) -> Iterator[Message]:
        """Yield the messages about these effects."""
        changed = False
        for effect in effects:
            display = fx.display_of(effect)
            if display.text and display.level is not None:
                said = display.text
                if not isinstance(effect, fx.Log):
                    said = f"{display.about} {said}"
                file, line = _place(getattr(effect, "place", ""))
                entry = {
                    "timestamp": json.loads(stamp(time_ns)),
                    "level": LEVELS[display.level],
                    "message": said,
                    "name": self._loaded.mission.mission,
                    "file": file,
                    "line": line,
                }
                yield self._log, _json(entry)
            if isinstance(effect, fx.Setpoints):
                yield self._setpoints, self._setpoints_message(effect)
            changed = self._note(effect) or changed
        if changed:
            yield self._states, _json(self._state)

    def _note(self, effect: fx.Effect) -> bool:
        """Remember the effect; return whether it has changed a state or the phase."""
        match effect:
            case fx.StateChange(states, unconfirmed):
                self._state |= zip(self._codes, states, strict=True)
                for (region, names), state in zip(self._codes.items(), states, strict=True):
                    self._state[_code_name(region)] = names.index(state)
                self._state["unconfirmed"] = " ".join(unconfirmed)
            case fx.PhaseChange(phase):
                self._state["phase"] = phase
            case fx.Detected(word):
                self._state["detected"] = word
            case _:
                return False
        return True

    def _setpoints_message(self, it: fx.Setpoints) -> bytes:
        named = zip(self._slots, it.values, strict=False)
        return _json({name: value for name, value in named if isfinite(value)})

    def _joint_message(self, now: str, shown: Sequence[float]) -> bytes:
        joints = []
        for opening, values in self._joints:
            for key, at in values:
                if isfinite(shown[at]):  # unknown values are left out
                    opening += key % shown[at]  # noqa: PLW2901 - it grows
            joints.append(opening)
        return f'{{"timestamp":{now},"joints":[{"},".join(joints)}}}]}}'.encode()


def _place(place: str) -> tuple[str, int]:
    """Return file and line of ``file:line:col``; empty and 0 without one."""
    file, _, rest = place.rpartition(":")[0].rpartition(":")
    return (file, int(rest)) if rest.isdigit() else ("", 0)


def _joints(loaded: LoadedMission) -> list[tuple[str, list[tuple[str, int]]]]:
    """Return the beginning of each joint's JSON, and its numbers with their indices."""
    body, numbers = loaded.loaded_robot.profile.body, loaded.robot.vocabulary.numbers
    signals_of = [
        *((joint.name, joint.name, None, joint.torque) for joint in body.joints),
        *((link.roll, link.roll, None, None) for link in body.links if link.roll),
        *((wheel.angle, wheel.angle, wheel.speed, None) for wheel in body.wheels),
    ]
    keys = ("position", "velocity", "effort")
    return [
        (
            f'{{"name":"{name}"',
            [
                (f',"{key}":%.9g', numbers.index(signal))
                for key, signal in zip(keys, signals, strict=True)
                if signal in numbers
            ],
        )
        for name, *signals in signals_of
    ]


def _gaps(names: Sequence[str]) -> tuple[str, ...]:
    """Return the members of a JSON object of numbers, with gaps for frequent formatting."""
    return tuple(f'"{name}":%.9g' for name in names)


def _filled(members: Sequence[str], values: Sequence[float]) -> Iterator[str]:
    """Yield the members with their values, without unknown and infinite ones."""
    for member, value in zip(members, values, strict=True):
        if isfinite(value):
            yield member % value


def _object(*members: str) -> bytes:
    return ("{" + ",".join(members) + "}").encode()


def _state_codes(robot: RobotSpec) -> dict[str, tuple[str, ...]]:
    """Return the states of each region in the order of the chart; a state's index is its code."""
    types = robot.vocabulary.types
    return {
        region: kind.values
        for region in robot.regions
        if isinstance(kind := types[region], EnumType)
    }


def _code_name(region: str) -> str:
    return f"{region}_code"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"{code} {name}" for code, name in enumerate(names))


def _json(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode()


ROLLS = ("joint_roll_rad", "front_roll_rad", "rear_roll_rad")


def columns_in_space(wheels: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns: z of each wheel, then the rolls."""
    return (*(f"{name}_z_m" for name in wheels), *ROLLS)


def values_in_space(space: InSpace) -> tuple[float, ...]:
    """Return the values of these columns."""
    return (*space.z_m, *space.rolls_rad)


def space_of(content: Mapping[str, Any], wheels: Sequence[str]) -> InSpace | None:
    """Return what a message has in these columns; None if it is of a robot in a plane."""
    names = columns_in_space(wheels)
    if any(name not in content for name in names):
        return None
    values = tuple(float(content[name]) for name in names)
    return InSpace(values[: len(wheels)], values[len(wheels) :])


def rolls_of(content: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the rolls in a message; empty if it has none."""
    return tuple(float(content[name]) for name in ROLLS) if content.keys() >= {*ROLLS} else ()

"""Prepare a run that resumes from a recording: its order, its equipment, its header."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from datetime import datetime
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from pirate_sm.checking.permissions import is_device
from pirate_sm.core import library
from pirate_sm.core.documents import LoadError, read_document, read_extended
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import Hint, RecordingError, UsageError
from pirate_sm.core.events import InSpace
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_there
from pirate_sm.core.resuming import DarkWay, Resumption, hypotheses
from pirate_sm.core.robot import known_values
from pirate_sm.robot.calibration_files import newest_calibration
from pirate_sm.robot.camera_file import opened_by
from pirate_sm.running.wiring import Order, Prepared, prepare
from pirate_sm.running.wiring.prepared import Say
from pirate_sm.simulation.standing import Standing

if TYPE_CHECKING:
    from pirate_sm.running.recording.format.header import RecordedFile, RunHeader
    from pirate_sm.running.recording.read.reader import Recording
    from pirate_sm.running.wiring.resume_offer import EndOfRun

COUNTING = ("odometry", "vision")
"""Detectors that count from where the robot is said to be."""

_EXTENDED = ("profile", "chart")
"""The roles of files that may extend another one; a recording holds them complete."""

COMMITTED_S = 0.5
"""What may be missing at the end of a recording, s: two intervals between writings."""


_MAY_DIFFER = ("port", "baud", "guard_for_s", "detector", "panel")
"""What a resumed run may have instead of what its recording says."""


def prepare_again(end: EndOfRun, asked: Order, say: Say = lambda text: None) -> Prepared:
    """Return the resumed run, ready to connect; nothing has moved.

    Mission, robot, pipe, parameters and joint zeros are those of the recording.

    Args:
        end: Where the recording was cut off.
        asked: Where the first wheel is, and what may differ from the recording; the rest of it
            does not count.
        say: Takes messages about steps that take longer than a moment.

    Raises:
        RecordingError: The recording is of a backend that cannot resume, or its robot is gone.
        UsageError: An option does not fit, the recording names an address as its port, which
            could be anything, or a detector that listens or opens a camera, or the robot's
            calibration has changed.
    """
    header = end.recording.header
    check_place(end.loaded, asked.start_at_m)
    order = _order(header, asked)
    if asked.port is None and not is_device(order.port or ""):
        message = f"the port of the recording, {order.port!r}, is not a device of this computer"
        hint = Hint(": if it is the right one, give it with --port", ": give it with port='PORT'")
        raise UsageError(message, hint=hint)
    opened = opened_by(order.detector or "", Path.cwd()) if asked.detector is None else ""
    if opened:
        message = f"the detector of the recording, '{order.detector}', opens {opened}"
        hint = Hint(": if you want it, give it with --detector", ": give it with detector='…'")
        raise UsageError(message, hint=hint)
    loaded = with_folder(end.loaded, header)
    if order.backend == "serial":
        _check_calibration(loaded, header)
    if order.backend in ("sim", "physics"):
        order = replace(order, put_back=_put_back(end, header))
    elif order.backend != "serial":
        raise RecordingError(
            f"cannot resume: a robot of the backend {order.backend} is gone with its "
            "program; run the mission again"
        )
    if (asked.detector or header.detector).partition(":")[0] in COUNTING:
        said_m = asked.start_at_m
        order = replace(order, start_at_m=first_wheel_m(end) if said_m is None else said_m)
    prepared = prepare(order, loaded, say)
    notices = (*lost(end.recording), *edited(header), *_missing(header), *prepared.notices)
    return replace(prepared, notices=notices)


def first_wheel_m(end: EndOfRun) -> float | None:
    """Return where the first wheel was along the pipe when the recording ends; None if unknown."""
    pipe, placed = end.loaded.pipe, end.placed
    if pipe is None or placed is None or not placed.wheels:
        return None
    (x, y), z = placed.wheels[0], placed.space.z_m[0] if placed.space and placed.space.z_m else 0.0
    return None if isnan(x) else pipe.route().arc_of((x, y, z))


def driven_s(end: EndOfRun, dark_s: float) -> float:
    """Return how long wheels may have been driven in the dark time, infinite if unknown.

    A simulated robot stops with its program. The firmware of a real one stops by itself if it has
    a dead man's switch.
    """
    if end.recording.header.backend != "serial":
        return 0.0
    serial = end.loaded.loaded_robot.profile.serial
    stop_after = serial.stop_after if serial is not None else None
    return dark_s if stop_after is None else min(dark_s, COMMITTED_S + stop_after)


def said_way(end: EndOfRun, way: DarkWay, start_at_m: float | None) -> DarkWay:
    """Return how far the robot has driven by where the first wheel is said to be.

    What the odometry counted from before stays known then. Without a word about it, or if the
    recording does not hold where the wheel was, it is what the wheels show.
    """
    was_m = first_wheel_m(end)
    if start_at_m is None or was_m is None:
        return way
    way_m = start_at_m - was_m
    return DarkWay(way_m, way_m, True, "the operator says where it is", seen=way.seen)


def with_resumption(
    prepared: Prepared, end: EndOfRun, it: Resumption, said: tuple[str, ...] = ()
) -> Prepared:
    """Return the run with the program that resumes, and with the header of its recording.

    Args:
        prepared: The run, as connected.
        end: Where the recording was cut off.
        it: What the mission resumes with.
        said: What the operator has said about the robot.
    """
    from pirate_sm.running.recording.format.header import ResumedRun
    from pirate_sm.running.recording.format.json_values import resumption_to_text

    recording = end.recording
    before = ResumedRun(
        *(recording.path.name, recording.sha256, end.last_step, end.last_s),
        resumption_to_text(it),
        said,
    )
    loaded = replace(prepared.loaded, program=it.program(prepared.loaded.program))
    engine = Engine(loaded.robot, loaded.program, nominal=prepared.engine.nominal)
    resumed = replace(recording.header, resumed=(*recording.header.resumed, before))
    return replace(prepared, loaded=loaded, engine=engine, resumed=resumed)


def header_again(prepared: Prepared, began: datetime, viewers: bool, speed: Any) -> RunHeader:
    """Return the header of the recording of a resumed run: that of the run before, changed."""
    from pirate_sm import __version__

    before = prepared.resumed
    assert before is not None
    options = {**before.options, "speed": speed, "port": prepared.order.port}
    return replace(
        before,
        began=began.isoformat(),
        detector=prepared.detector,
        options=options,
        viewers=viewers,
        version=__version__,
    )


# --- inside -----------------------------------------------------------------------------------


def _order(header: RunHeader, asked: Order) -> Order:
    given = {name: value for name in _MAY_DIFFER if (value := getattr(asked, name)) is not None}
    return replace(
        recorded_order(header),
        **{"panel": None, **given},
        forecast=None,  # earlier runs did not begin where this one does
        backend=header.backend,
        calibration=False,
        check=False,
        also=None,
        ruler=False,
        start_at_m=None,
        breakpoints=asked.breakpoints,
    )


def recorded_order(header: RunHeader) -> Order:
    """Return the order of a recorded run.

    Raises:
        RecordingError: The recording has none.
    """
    known = {each.name for each in fields(Order)}
    given: Mapping[str, Any] = {k: v for k, v in header.options.items() if k in known}
    try:
        return TypeAdapter(Order).validate_python({"mission": header.mission, **given})
    except ValidationError:
        raise RecordingError("the options in the recording are not those of a run") from None


def with_folder(loaded: LoadedMission, header: RunHeader) -> LoadedMission:
    """Return the mission with the robot's own folder, which has the definitions of its messages."""
    profile = next(file for file in header.files if file.role == "profile")
    folder = _place_of(profile).parent
    return replace(loaded, loaded_robot=replace(loaded.loaded_robot, folder=folder))


def lost(recording: Recording) -> tuple[str, ...]:
    """Return a notice about what a repaired recording lacks; none if that is what a crash costs."""
    when = [f"from {gap.from_s:.3f} s to {gap.until_s:.3f} s" for gap in recording.gaps]
    if recording.lost_end:
        when.append(f"after {recording.until_s:.3f} s")
    said = "the recording was damaged and has been repaired: what the robot did"
    return (f"{said} {' and '.join(when)} is unknown",) if when else ()


def edited(header: RunHeader) -> tuple[str, ...]:
    """Return a notice about each file that has changed since the recording."""
    return tuple(
        f"{shown(path)} has changed since; the {file.role} of the recording counts"
        for file in header.files
        if is_there(path := _place_of(file)) and _text_now(path, file) != file.text
    )


def _text_now(path: Path, file: RecordedFile) -> str | None:
    """Return what a file says today, with what it extends; None if it cannot be read."""
    try:
        now = read_extended(path) if file.role in _EXTENDED else read_document(path)
    except LoadError:
        return None
    return now.complete_text


def _missing(header: RunHeader) -> tuple[str, ...]:
    """Return a notice about each file that is not where it was; it may lie in another folder."""
    return tuple(
        f"{shown(path)} is not there any more; the {file.role} of the recording counts"
        for file in header.files
        if not is_there(path := _place_of(file))
    )


def _place_of(file: RecordedFile) -> Path:
    """Return where a file was when the run was recorded, seen from the current folder."""
    inside = file.path.removeprefix("shipped:")
    return Path(inside) if inside == file.path else library.shipped() / inside


def check_place(loaded: LoadedMission, start_at_m: float | None) -> None:
    """Refuse a place of the first wheel that is outside the pipe.

    Raises:
        UsageError: It is.
    """
    if start_at_m is None or loaded.pipe is None:
        return
    length_m = loaded.pipe.route().length_m
    if not 0.0 <= start_at_m <= length_m:
        raise UsageError(
            f"the first wheel cannot be at {start_at_m:g} m, the pipe goes from 0 to {length_m:g} m"
        )


def _check_calibration(loaded: LoadedMission, header: RunHeader) -> None:
    """Refuse a robot whose joint zeros are others now: its angles would mean something else.

    Raises:
        UsageError: They are others.
    """
    used = bool(header.options.get("calibration", True))
    newest = newest_calibration(loaded.loaded_robot) if used else None
    zeros = dict(newest.zeros) if newest is not None else {}
    if zeros != dict(header.zeros):
        raise UsageError(
            "the robot was recalibrated since the recording: its joint zeros are others now"
        )


def _put_back(end: EndOfRun, header: RunHeader) -> Standing:
    """Return the pose of a simulated robot when the recording ends.

    Raises:
        RecordingError: That was not recorded.
    """
    loaded, last, placed = end.loaded, end.last, end.placed
    profile, numbers = loaded.loaded_robot.profile, loaded.robot.vocabulary.numbers
    known = dict(zip(numbers, last.sensing.numbers, strict=True))
    joints = profile.body.joints
    bends = {joint.name: known.get(joint.name, nan) for joint in joints}
    torques = {joint.name: known.get(joint.torque or "", nan) for joint in joints}
    in_space = loaded.pipe is not None and loaded.pipe.section != "bars"
    if in_space and header.backend != "sim":
        raise RecordingError(
            f"a robot of the backend {header.backend} cannot be put back in a round pipe; run the "
            "mission again"
        )
    if placed is None or not placed.known or any(map(isnan, (*bends.values(), *torques.values()))):
        raise RecordingError("where the simulated robot was is not in the recording")
    beside = placed.space
    if not in_space:
        # Recordings of earlier versions hold no rolls in a plane.
        beside = InSpace((), placed.rolls_rad or _rolls_in_plane(loaded, last, known))
    if beside is None:
        raise RecordingError("where the simulated robot was in space is not in the recording")
    body = hypotheses(loaded.robot, loaded.program, last)[0].body
    z_m = beside.z_m or (0.0,) * len(placed.wheels)
    return Standing(
        tuple((x, y, z) for (x, y), z in zip(placed.wheels, z_m, strict=True)),
        tuple(bends.values()),
        tuple(torques.values()),
        known_values(body.values, last.sensing.numbers, loaded.robot),
        end.last_s - end.began_s,
        beside.rolls_rad,
    )


def _rolls_in_plane(
    loaded: LoadedMission, last: EngineState, known: Mapping[str, float]
) -> tuple[float, ...]:
    """Return the angle of the roll joint, and the rolls of the parts ahead and behind.

    A part that holds stays as the robot was at its start; the other one has turned.
    """
    body, robot = loaded.loaded_robot.profile.body, loaded.robot
    joint = next((link.roll for link in body.links if link.roll is not None), None)
    angle = known.get(joint, nan) if joint is not None else 0.0
    angle = 0.0 if isnan(angle) else angle
    held = {robot.parts[part] for part in robot.held[last.robot.configuration]}
    behind_holds = body.wheels[-1].part in held
    start = loaded.pipe.roll if loaded.pipe is not None else 0.0
    return (angle, start + angle, start) if behind_holds else (angle, start, start - angle)

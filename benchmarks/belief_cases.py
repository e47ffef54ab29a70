"""Draws a run that tries what a mission believes: its pipe, friction and defects, from a seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import atan, degrees
from pathlib import Path
from random import Random
from types import MappingProxyType
from typing import Any, NamedTuple

import yaml

from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.core.units import LENGTH, read_quantity
from pirate_sm.running.wiring import Order

LEAST_FRICTION, MOST_FRICTION, GOOD_FRICTION = 0.05, 0.9, 0.3
_BORES_MM = (120, 118, 115, 112, 110)
_LATEST_S = 30.0
_HOLDS = 0.9
"""Share of the friction that a slope may ask of a loose robot with nothing wrong."""
_START_JITTER_M = 0.02


class Way(NamedTuple):
    """A mission, and what is drawn for it.

    Attributes:
        mission: Its name.
        pipes: Shipped pipes, one of which is taken and changed; an empty name: its own straight.
        ends: What a success claims: a ``distance`` or a ``word``.
        parameter: The parameter that says how far, with the range in mm from which it is drawn.
        asked: Share of that at which the robot is when it has succeeded; None: nothing is asked
            that truth could be held against but the robot's own estimate.
        path: How often it drives this way, forth and back.
        steps: Whether the pipe may be round with steps of the bore.
        loose: Whether the robot begins loose; then a pipe without steps is not round, where it
            would lie on the floor.
        slopes: Ranges of slopes, deg.
        settings: Other parameters.
    """

    mission: str
    pipes: tuple[str, ...] = ("",)
    ends: str = "distance"
    parameter: tuple[str, int, int] | None = None
    asked: float | None = None
    path: float = 1.0
    steps: bool = False
    loose: bool = False
    slopes: tuple[tuple[float, float], ...] = ((0, 0),)
    settings: Mapping[str, str] = {}


_SLOPES = ((0, 0), (-20, 20))
_MITRES = ("mitre_90", "mitre_60", "mitre_45", "mitre_90_115mm")
_QUICK = {"hold": "2 s"}
_STATIONS = {"stay": "1 s", "stations": "2"}
WAYS = (
    Way("drive_on", parameter=("way", 100, 900), asked=1, steps=True, slopes=(*_SLOPES, (60, 90))),
    Way("mitre_bend", _MITRES, "word"),
    Way("climb", parameter=("height", 150, 600), asked=0, path=2, steps=True, slopes=((30, 90),),
        settings=_QUICK),
    Way("mitre_bend_backward", ("mitre_90_backward",), "word"),
    Way("enter_2d", parameter=("way", 100, 600), steps=True, loose=True, slopes=_SLOPES),
    Way("take_bend", ("mitre_90_round", "mitre_90_from_below", "mitre_90_up"), "word"),
    Way("inspect", parameter=("apart", 60, 120), asked=0, path=4, settings=_STATIONS),
    Way("mitre_bend_other_side", ("mitre_90_other_side",), "word"),
    Way("enter_3d", ("straight_113_upright",), parameter=("way", 50, 250)),
    Way("take_elbow", ("elbow_90",), "word"),
    Way("exp_1_round", ("straight_113",), parameter=("far", 200, 500), path=2),
    Way("exp_2c_tilted", ("mitre_90_tilted",), "word"),
    Way("level", ("straight_113_rolled",), parameter=("way", 50, 250)),
    Way("take_branch", ("tee_90",), "word"),
    Way("exp_1a_both", ("straight_113",), parameter=("far", 200, 500), path=6),
    Way("take_elbow_backward", ("elbow_90_backward",), "word"),
    Way("drive_on", parameter=("way", 100, 900), asked=1, steps=True, slopes=_SLOPES),
    Way("take_branch_backward", ("tee_90_backward",), "word"),
)  # fmt: skip
"""The shipped missions that end by a distance or by a word, but for those that only call others."""

TROUBLES: Sequence[tuple[str, int]] = (
    ("nothing", 0), ("nothing", 0), ("pipe", 0), ("one defect", 1), ("two defects", 2),
    ("nothing", 0), ("pipe", 0), ("pipe, one", 1), ("one defect", 1), ("pipe, two", 2),
    ("two defects", 2),
)  # fmt: skip
"""What is wrong in runs that follow each other, and how many defects that is."""


@dataclass(frozen=True)
class Case:
    """A drawn run.

    Attributes:
        number: Its number, from which and the seed it is drawn.
        trouble: What is wrong, of ``TROUBLES``.
        way: Its mission.
        order: How it is run; its pipe is a file.
        asked_m: Where the robot is to be when it has succeeded; None: nowhere in particular.
        path_m: How far it drives.
    """

    number: int
    trouble: str
    way: Way
    order: Order
    asked_m: float | None
    path_m: float


def case_of(
    seed: int,
    number: int,
    folder: Path,
    missions: Sequence[str] = (),
    backend: str = "sim",
    robot: Mapping[str, str] = MappingProxyType({}),
) -> Case:
    """Return a drawn run, and write its pipe.

    Args:
        seed: Of all runs.
        number: Of this run.
        folder: Where its pipe is written.
        missions: Those from which its mission is taken; empty: all.
        backend: What simulates it.
        robot: Numbers of the simulated robot, as ``--number`` takes them.
    """
    lot = Random(f"{seed}:{number}")
    ways = [way for way in WAYS if not missions or way.mission in missions]
    way = ways[number % len(ways)]
    trouble, count = TROUBLES[number // len(ways) % len(TROUBLES)]
    settings, driven_m = dict(way.settings), 0.0
    if way.parameter is not None:
        name, least, most = way.parameter
        driven_m = lot.randint(least, most) / 1000
        settings[name] = f"{driven_m * 1000:.0f} mm"
    pipe = _pipe(lot, way, "pipe" in trouble, driven_m)
    file = folder / f"{way.mission}_{seed}_{number}.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(pipe, sort_keys=False), encoding="utf-8")
    detector = lot.choice(("sim", "odometry")) if way.ends == "word" else None
    profile = library.find_robot("pirate_ii_imu" if way.mission == "level" else "pirate_ii")
    order = Order(
        way.mission,
        backend,
        pipe=str(file),
        settings=settings,
        seed=number,
        start_jitter_m=_START_JITTER_M,
        numbers=robot,
        defects=tuple(
            _defect(lot, name, str(profile)) for name in _names(lot, str(profile), count)
        ),
        detector=detector,
    )
    asked_m = None if way.asked is None else way.asked * driven_m
    return Case(number, trouble, way, order, asked_m, way.path * driven_m)


def _pipe(lot: Random, way: Way, wrong: bool, driven_m: float) -> dict[str, Any]:
    """Return a pipe; something may be wrong with it: a step, a patch, or too little friction."""
    base = lot.choice(way.pipes)
    pipe: dict[str, Any] = (
        yaml.safe_load(library.find_pipe(base).read_text(encoding="utf-8"))
        if base
        else {"format": 1, "diameter": "120 mm", "segments": [{"straight": "3 m"}],
              "start": {"at": "1 m"}}
    )  # fmt: skip
    slope = lot.uniform(*lot.choice(way.slopes))
    trouble = lot.choice(
        ("step", "step", "friction", "patch") if way.steps else ("friction", "patch")
    )
    least = LEAST_FRICTION if wrong and trouble == "friction" else GOOD_FRICTION
    friction = lot.uniform(least, GOOD_FRICTION if least < GOOD_FRICTION else MOST_FRICTION)
    pipe["friction"] = _coefficients(lot, friction)
    if way.loose and not wrong:  # on a steeper slope it slides before anything can hold it
        steepest = degrees(atan(_HOLDS * pipe["friction"]["kinetic"]))
        slope = min(max(slope, -steepest), steepest)
    if not base:
        stepped = wrong and trouble == "step"
        pipe |= _course(lot, slope, stepped, driven_m) if stepped or not way.loose else _bars(slope)
    if wrong and trouble == "patch":
        pipe["patches"] = [_patch(lot, pipe, driven_m)]
    return pipe


def _patch(lot: Random, pipe: Mapping[str, Any], driven_m: float) -> dict[str, Any]:
    """Return a slippery patch of the wall, somewhere on the robot's way."""
    length_m = sum(_metres(each["straight"]) for each in pipe["segments"] if "straight" in each)
    start = pipe.get("start", {}).get("at")
    at_m = _metres(start) if start else 0.5 * length_m
    begin_m = min(max(0.0, at_m + lot.uniform(-0.3, max(0.3, driven_m))), length_m - 0.1)
    end_m = min(begin_m + lot.uniform(0.05, 0.3), length_m)
    coefficients = _coefficients(lot, lot.uniform(LEAST_FRICTION, 0.2))
    return {"from": f"{begin_m:.3f} m", "to": f"{end_m:.3f} m", **coefficients}


def _metres(text: str) -> float:
    return read_quantity(text, LENGTH)


def _course(lot: Random, slope: float, stepped: bool, driven_m: float) -> dict[str, Any]:
    """Return a straight of 3 m, which may have a step of the bore on the robot's way."""
    if not stepped:
        if lot.random() < 0.5:
            return _bars(slope)
        return {"section": "round", "frame": {"pitch": f"{slope:.1f} deg"}}
    first, then = lot.sample(_BORES_MM, 2)
    at_m = 1.0 + lot.uniform(0.02, driven_m + 0.15)
    length = lot.choice(("0 mm", "1 mm", "1 mm", f"{lot.randint(40, 150)} mm"))
    return {
        "section": "round",
        "frame": {"pitch": f"{slope:.1f} deg"},
        "diameter": f"{first} mm",
        "segments": [
            {"straight": f"{at_m:.3f} m"},
            {"reducer": length, "to": f"{then} mm"},
            {"straight": f"{3.2 - at_m:.3f} m"},
        ],
    }


def _bars(slope: float) -> dict[str, str]:
    return {"tilt": f"{slope:.1f} deg", "uphill": "0 deg"}


def _coefficients(lot: Random, static: float) -> dict[str, float]:
    return {"static": round(static, 3), "kinetic": round(static * lot.uniform(0.7, 1.0), 3)}


def _names(lot: Random, robot: str, count: int) -> list[str]:
    return lot.sample(sorted(_defects(robot)), count)


@cache
def _defects(robot: str) -> Mapping[str, str]:
    """Return the kinds of a robot's defects, by name."""
    defects = load_robot(Path(robot)).profile.simulation.defects
    return {name: defect.kind for name, defect in defects.items()}


def _defect(lot: Random, name: str, robot: str) -> str:
    """Return a defect with drawn numbers and a drawn time, as it is written."""
    kind = _defects(robot)[name]
    after_s = lot.choice((0.0, *[lot.uniform(0.0, _LATEST_S)] * 5))
    numbers = {"after": f"{after_s:.2f}s"}
    if kind == "stiff_joint":
        numbers["friction"] = f"{lot.uniform(0.1, 1.0):.2f}Nm"
    elif kind == "dead_wheel" and lot.random() < 0.5:
        numbers["friction"] = f"{lot.uniform(0.02, 0.15):.3f}Nm"
    elif kind == "zero_jump":
        numbers["by"] = f"{lot.choice((-1, 1)) * lot.uniform(3.0, 25.0):.1f}deg"
    elif kind == "lost_messages":
        numbers["share"] = f"{lot.uniform(0.05, 0.4):.2f}"
    elif kind == "sensor_stuck" and name.startswith("gamma") and lot.random() < 0.3:
        numbers["shows"] = f"{lot.uniform(-110.0, 110.0):.0f}deg"
    elif kind in ("silent_boards", "silent_bay") and lot.random() < 0.3:
        numbers["lasting"] = f"{lot.uniform(0.3, 5.0):.2f}s"
    return f"{name}:{','.join(f'{key}={value}' for key, value in numbers.items())}"

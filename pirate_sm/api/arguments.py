"""Reads what a caller of the API names: a mission and the options that change it."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from math import isnan
from numbers import Integral, Real
from os import PathLike, fspath
from typing import Any, TypeAlias, TypedDict, Unpack, cast

from pirate_sm import wiring
from pirate_sm.checking.allowances import settle
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import check_loaded
from pirate_sm.checking.project.check_options import Wishes
from pirate_sm.checking.project.check_project import check_paths
from pirate_sm.errors import UsageError
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.defect_text import as_text
from pirate_sm.model.fidelity import Fidelity
from pirate_sm.spelling import unknown
from pirate_sm.wiring import Order, Prepared

LOG = logging.getLogger("pirate_sm")
"""Tells at level INFO what takes longer than a moment."""

Mission: TypeAlias = str | PathLike[str] | LoadedMission
"""A shipped mission's name, the path of a file, or what :func:`load` has returned."""


class Options(TypedDict, total=False):
    """Options that ``run``, ``session`` and ``sweep`` share; all may be left out.

    Attributes:
        robot: Name or path of a robot, instead of the mission's own.
        pipe: Name or path of a pipe, instead of the mission's own.
        set: Values of parameters by name, as a mission writes them: ``{"give_up": "30 s"}``.
        start_phase: The phase to begin with, instead of the mission's own.
        states: State names by region that the robot is in, instead of ``starts_in``.
        defects: Known defects of the simulated robot, each as text,
            ``"stiff_joint:friction=0.5Nm,after=2s"``, or as a mapping,
            ``{"defect": "stiff_joint", "after": "2 s"}``.
        twin: File with numbers of the simulated robot, from ``pirate fit --robot``.
        fitted: Such a file with numbers of the motors, by which any robot is judged.
        start_jitter_m: How far a simulated robot may start from its place; likewise
            ``diameter_jitter_m`` of the pipe, and ``friction_jitter`` as a share.
        fidelity: How finely the backend ``sim`` computes: ``"usual"``, or ``"fast"``, with half the
            iterations, which is coarser.
        detector: Name of a detector, instead of the backend's usual one.
        also: A second detector, whose words are logged and do nothing.
        ruler: Whether a simulated ruler measures the robot's speed from outside, for slip.
        view: Whether MuJoCo's own viewer shows the run; the backend ``physics`` alone has one.
        start_at_m: Where odometry takes the first wheel to begin, instead of the pipe's own.
        port: Where a real robot is, a device or a URL of pyserial; ``baud`` instead of its rate.
    """

    robot: str | PathLike[str] | None
    pipe: str | PathLike[str] | None
    set: Mapping[str, object] | None
    start_phase: str | None
    states: Mapping[str, str] | None
    defects: Iterable[str | Mapping[str, object]]
    twin: str | None
    fitted: str | PathLike[str] | None
    start_jitter_m: float
    diameter_jitter_m: float
    friction_jitter: float
    fidelity: Fidelity
    detector: str | None
    also: str | None
    ruler: bool
    view: bool
    start_at_m: float | None
    port: str | None
    baud: int | None


def load(
    mission: str | PathLike[str],
    *,
    robot: str | PathLike[str] | None = None,
    pipe: str | PathLike[str] | None = None,
    set: Mapping[str, object] | None = None,
    fitted: str | PathLike[str] | None = None,
) -> LoadedMission:
    """Return a mission with its robot and its pipe, ready to be run any number of times.

    Args:
        mission: A shipped mission's name, or the path of a file.
        robot: Name or path of a robot, instead of the mission's own.
        pipe: Name or path of a pipe, instead of the mission's own.
        set: Values of parameters by name, as a mission writes them: ``{"give_up": "30 s"}``.
        fitted: File with numbers of the robot's motors, from ``pirate fit --robot``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        UsageError: An argument does not fit.
    """
    robot, pipe, fitted = _path_or_none(robot), _path_or_none(pipe), _path_or_none(fitted)
    settings = texts(set)
    return wiring.load(
        Order(path_of(mission), robot=robot, pipe=pipe, settings=settings, fitted=fitted)
    )


def check(
    mission: Mission,
    *,
    robot: str | PathLike[str] | None = None,
    pipe: str | PathLike[str] | None = None,
    set: Mapping[str, object] | None = None,
) -> tuple[Finding, ...]:
    """Return what is wrong with a mission, by place, without what its files allow.

    Faults of a file are findings like all others: nothing is raised for them.

    Args:
        mission: The mission; also a robot's folder, a pipe or a project's folder.
        robot: Name or path of a robot, instead of the mission's own.
        pipe: Name or path of a pipe, instead of the mission's own.
        set: Values of parameters by name.

    Raises:
        UsageError: A path leads nowhere, or an argument does not fit.
    """
    if isinstance(mission, LoadedMission):
        _refuse_options(robot=robot, pipe=pipe, set=set)
        files = {document.name: document.text for document in mission.documents}
        return tuple(f for f in settle(check_loaded(mission).findings, files) if not f.allowed)
    robot, pipe = _path_or_none(robot), _path_or_none(pipe)
    wishes = Wishes(robot=robot, pipe=pipe, settings=texts(set), keep_going=False)
    return check_paths([path_of(mission)], wishes).open


def prepared(
    mission: Mission,
    backend: str,
    seed: int,
    *,
    check: bool,
    yes: bool,
    **options: Unpack[Options],
) -> Prepared:
    """Return what a run of the mission needs; nothing has moved.

    Args:
        mission: The mission.
        backend: Name of the backend.
        seed: Of everything random.
        check: Whether a mission in which the check finds errors is refused.
        yes: Whether the caller agrees that a real robot moves.
        options: All others.

    Raises:
        LoadError: Everything that is wrong with the files.
        CheckError: The mission is refused.
        UsageError: An argument does not fit, or nobody has agreed that a robot moves.
    """
    loaded = mission if isinstance(mission, LoadedMission) else None
    order = _order(mission, backend, seed, check=check, **options)
    found = wiring.prepare(order, loaded, LOG.info)
    if found.confirmation and not yes:
        raise UsageError(f"{found.confirmation}: agree to it with yes=True")
    if found.detector == "operator":
        raise UsageError("the detector 'operator' needs a person at a keyboard")
    return found


def _order(
    mission: Mission, backend: str, seed: int, *, check: bool, **options: Unpack[Options]
) -> Order:
    """Return the order that the arguments of an API function make.

    Raises:
        UsageError: The mission is loaded already and an option would have to change that.
    """
    rest: dict[str, Any] = dict(options)
    _refuse_unknown(rest)
    settings, defects = texts(rest.pop("set", None)), rest.pop("defects", ())
    if isinstance(mission, LoadedMission):
        _refuse_options(set=settings, **{name: rest.get(name) for name in _PATHS})
        if any(map(rest.get, _OF_START)):
            raise UsageError("start_phase and states need the mission by its name or file")
        name = mission.documents[0].name
    else:
        name = path_of(mission)
    for option in _PATHS:
        rest[option] = _path_or_none(rest.get(option))
    defects = (defects,) if isinstance(defects, str | Mapping) else defects
    if isinstance(defects, Iterable):
        defects = tuple(as_text(each) for each in defects)
    _refuse_kinds({**rest, "backend": backend, "defects": defects})
    rest |= {name: float(rest[name]) for name in _NUMBERS if rest.get(name) is not None}
    return Order(
        name,
        backend,
        seed=whole(seed, "seed", 0),
        settings=settings,
        defects=defects,
        check=check,
        **rest,
    )


def loaded_once(mission: Mission, **options: Unpack[Options]) -> tuple[Mission, Options]:
    """Return the mission loaded, where one can be run with these options, and the other options.

    Raises:
        LoadError: Everything that is wrong with the files.
        UsageError: An argument does not fit.
    """
    if isinstance(mission, LoadedMission) or any(map(options.get, _OF_START)):
        return mission, options
    rest: dict[str, Any] = dict(options)
    of_loading = {name: rest.pop(name, None) for name in _OF_LOADING}
    return load(mission, **of_loading), cast(Options, rest)


def path_of(name: object) -> str:
    """Return the name or path of a file as text.

    Raises:
        UsageError: It is something else.
    """
    if not isinstance(name, str | PathLike):
        raise UsageError(f"expected a name or a path, got {name!r}")
    return str(fspath(name))


def _path_or_none(name: object) -> str | None:
    return None if name is None else path_of(name)


def is_number(value: object) -> bool:
    """Return whether the value is a number; NaN and truth values are none."""
    return not isinstance(value, bool) and isinstance(value, Real) and not isnan(value)


def whole(number: Any, what: str, least: int) -> int:
    """Return the number, if it is an integer that is not too small.

    Raises:
        UsageError: It is something else.
    """
    if isinstance(number, bool) or not isinstance(number, Integral) or number < least:
        raise UsageError(f"{what}: expected a whole number from {least} on, got {number!r}")
    return int(number)


def _refuse_kinds(options: Mapping[str, object]) -> None:
    for names, fits, expected in (
        (_NUMBERS[:3], is_number, "a number"),
        (_NUMBERS[3:], lambda value: value is None or is_number(value), "a number of m"),
        (("detector", "start_phase", "port"), lambda v: isinstance(v, str | None), "a text"),
        (("ruler", "view"), lambda value: isinstance(value, bool), "True or False"),
        (("backend",), lambda value: isinstance(value, str), "the name of a backend"),
        (("states",), _are_states, "names of states by region"),
        (("defects",), _are_defects, "names of defects"),
    ):
        for name in names:
            if name in options and not fits(options[name]):
                raise UsageError(f"{name}: expected {expected}, got {options[name]!r}")


def _are_states(value: object) -> bool:
    if not isinstance(value, Mapping):
        return value is None
    return all(isinstance(text, str) for text in (*value.keys(), *value.values()))


def _are_defects(value: object) -> bool:
    return isinstance(value, tuple) and all(isinstance(each, str) for each in value)


def _refuse_unknown(options: Mapping[str, object]) -> None:
    if wrong := unknown("there is no option", options, sorted(Options.__annotations__)):
        raise UsageError(wrong)


_NUMBERS = ("start_jitter_m", "diameter_jitter_m", "friction_jitter", "start_at_m")
_PATHS = ("robot", "pipe", "fitted")
_OF_LOADING = (*_PATHS, "set")
_OF_START = ("start_phase", "states")
"""Where a mission begins is written into a recording with the options, not with the mission."""


def texts(values: Mapping[str, object] | None) -> dict[str, str]:
    """Return values of parameters as a command line would give them.

    Raises:
        UsageError: They are not given by name.
    """
    if not isinstance(values, Mapping | None):
        raise UsageError(f"set: expected values by the names of parameters, got {values!r}")
    return {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in (values or {}).items()
    }


def _refuse_options(**options: object) -> None:
    given = [name for name, value in options.items() if value]
    if given:
        raise UsageError(f"the mission is loaded already: give {', '.join(given)} to load()")

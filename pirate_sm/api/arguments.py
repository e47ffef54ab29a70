"""Reads what a caller of the API names: a mission and the options that change it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from math import isnan
from numbers import Integral, Real
from os import PathLike, fspath
from typing import Any, Literal, TypeAlias, Unpack, cast, get_args, get_origin, get_type_hints

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Finding, settle
from pirate_sm.checking.mission.check_mission import check_loaded
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.options import OPTIONS, Options, defect_as_text
from pirate_sm.core.spelling import unknown
from pirate_sm.running import wiring
from pirate_sm.running.wiring import Order, Prepared

LOG = logging.getLogger("pirate_sm")
"""Tells at level INFO what takes longer than a moment."""

Mission: TypeAlias = str | PathLike[str] | LoadedMission
"""A shipped mission's name, the path of a file, or what :func:`load` has returned."""


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
    mission: Mission, backend: str, seed: int, *, check: bool, yes: bool, **options: Unpack[Options]
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
    for name, value in (("check", check), ("yes", yes)):
        if not isinstance(value, bool):  # "no" would count as consent to a robot that moves
            raise UsageError(f"{name}: expected True or False, got {value!r}")
    loaded = mission if isinstance(mission, LoadedMission) else None
    order = _order(mission, backend, seed, check=check, **options)
    found = wiring.prepare(order, loaded, LOG.info)
    if found.confirmation and not yes:
        raise UsageError(f"{found.confirmation}: agree to it with yes=True")
    if found.detector == "operator":
        raise UsageError("the detector 'operator' needs an operator at a keyboard")
    return found


def _order(
    mission: Mission, backend: str, seed: int, *, check: bool, **options: Unpack[Options]
) -> Order:
    """Return the order that the arguments of an API function make.

    Raises:
        UsageError: The mission is loaded already and an option would have to change that.
    """
    rest: dict[str, Any] = dict(options)
    if wrong := unknown("there is no option", rest, sorted(_TYPES)):
        raise UsageError(wrong)
    settings = texts(rest.pop("set", None))
    numbers = texts(rest.pop("numbers", None), "numbers: expected values by the keys of a twin")
    if isinstance(mission, LoadedMission):
        _refuse_options(set=settings, **{name: rest.get(name) for name in _PATHS})
        if any(map(rest.get, _OF_START)):
            raise UsageError("start_phase and states need the mission by its name or file")
        name = mission.documents[0].name
    else:
        name = path_of(mission)
    if not isinstance(backend, str):
        raise UsageError(f"backend: expected the name of a backend, got {backend!r}")
    return Order(
        name,
        backend,
        seed=whole(seed, "seed", 0),
        settings=settings,
        numbers=numbers,
        check=check,
        **{option: _taken(option, value) for option, value in rest.items()},
    )


def _taken(name: str, value: Any) -> Any:
    """Return the value of an option as an order has it.

    Raises:
        UsageError: It is of another kind.
    """
    kind = _TYPES[name]
    if kind == _TYPES["pipe"]:
        return _path_or_none(value)
    if name == "defects":
        listed = (value,) if isinstance(value, str | Mapping) else value
        value = tuple(map(defect_as_text, listed)) if isinstance(listed, Iterable) else listed
    if kind == int | None and value is not None:
        return whole(value, name, OPTIONS[name].least or 0)
    if get_origin(kind) is Literal and value not in get_args(kind):
        raise UsageError(f"{name}: expected {' or '.join(get_args(kind))}, got {value!r}")
    fits, expected = _EXPECTED.get(kind, (lambda value: True, ""))
    if not fits(value):
        raise UsageError(f"{name}: expected {expected}, got {value!r}")
    return value if value is None or OPTIONS[name].unit is None else float(value)


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


def _are_states(value: object) -> bool:
    if not isinstance(value, Mapping):
        return value is None
    return all(isinstance(text, str) for text in (*value.keys(), *value.values()))


def _are_defects(value: object) -> bool:
    return isinstance(value, tuple) and all(isinstance(each, str) for each in value)


_TYPES = get_type_hints(Options)
_EXPECTED: Mapping[Any, tuple[Callable[[Any], bool], str]] = {
    float: (is_number, "a number"),
    float | None: (lambda value: value is None or is_number(value), "a number of m"),
    str | None: (lambda value: isinstance(value, str | None), "a text"),
    bool: (lambda value: isinstance(value, bool), "True or False"),
    _TYPES["states"]: (_are_states, "names of states by region"),
    _TYPES["defects"]: (_are_defects, "names of defects"),
}
"""What a value must be, and what is said where it is not, by the type that is declared."""

_PATHS = ("robot", "pipe", "fitted")
_OF_LOADING = (*_PATHS, "set")
_OF_START = ("start_phase", "states")
"""Where a mission begins is written into a recording with the options, not with the mission."""


def texts(
    values: Mapping[str, object] | None,
    expected: str = "set: expected values by the names of parameters",
) -> dict[str, str]:
    """Return values as a command line would give them.

    Raises:
        UsageError: They are not given by name.
    """
    given: Any = values  # mypy reads only some of the callers
    if not isinstance(given, Mapping | None) or not all(
        isinstance(key, str) for key in given or ()
    ):
        raise UsageError(f"{expected}, got {values!r}")
    return {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in (values or {}).items()
    }


def _refuse_options(**options: object) -> None:
    given = [name for name, value in options.items() if value]
    if given:
        raise UsageError(f"the mission is loaded already: give {', '.join(given)} to load()")

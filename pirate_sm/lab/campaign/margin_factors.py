"""What can be changed round a cell of a campaign, and how the order of a run says so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256

from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission, simulated_profile
from pirate_sm.core.models import PARTS_OF_A_TWIN, Profile
from pirate_sm.core.options import DEFECT_KEYS, OF_PIPE, keys_of_defect
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import (
    DIMENSIONLESS,
    Dimension,
    QuantityError,
    parse_quantity,
    read_quantity,
    unit_of,
)
from pirate_sm.lab.campaign.margins_model import READ_IN, MarginBound, MarginFactor, Margins
from pirate_sm.lab.campaign.plan import Cell
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.changed_pipe import PIPE_NUMBERS, changed_pipe, numbers_of
from pirate_sm.simulation.defects import named

_EACH = "each:"

_USUAL_RANGES: Mapping[str, tuple[float, float]] = {
    "friction": (0.1, 2.0),
    "diameter": (0.92, 1.08),
    "motors": (0.25, 2.0),
    "joints": (0.25, 2.0),
    "noise": (1.0, 10.0),
    "tyre": (0.0, 4.0),
}
"""The range of a factor that gives none, by its value in the files [decided]."""

_USUAL_WAYS: Mapping[str, float] = {"tilt": 0.7854, "roll": 0.7854, "start": 0.2}
"""The same for those that may be zero: so much to either side, rad or m [decided]."""

_USUAL_FROM_ZERO: Mapping[str, float] = {"tyre.rolling_resistance": 0.04}
"""The end of the range of a factor that gives none and is zero in the files [decided]."""

_NOTHING = ("share", "by")
"""Numbers of defects with which, at zero, a run is the same as without the defect."""

_USUAL_KINDS = ("lost_messages",)
"""Kinds of defects with a number that is varied if no factors are named."""


def changed(order: Order, values: Mapping[MarginFactor, float]) -> Order:
    """Return the order with factors at these values.

    At their nominal ones it is the same, but for defects that are added.
    """
    numbers, defects = dict(order.numbers), dict[str, list[str]]()
    for factor, value in values.items():
        if not factor.added and factor.rounded(value) == factor.rounded(factor.nominal):
            continue
        text = factor.written(value).replace(" ", "")
        defect, colon, key = factor.name.partition(":")
        if colon:
            defects.setdefault(defect, []).append(f"{key}={text}")
        else:
            numbers[f"{OF_PIPE}{defect}" if defect in PIPE_NUMBERS else defect] = text
    added = (f"{defect}:{','.join(pairs)}" for defect, pairs in defects.items())
    return replace(order, numbers=numbers, defects=(*order.defects, *added))


def level_of(cell: Cell, values: Mapping[MarginFactor, float]) -> Cell:
    """Return the cell with factors at these values; see :func:`changed`."""
    order = changed(cell.order, values)
    if order == cell.order:
        return cell
    said = ", ".join(f"{each.name} {each.written(value)}" for each, value in values.items())
    key = sha256(f"{cell.key} {order.numbers} {order.defects}".encode()).hexdigest()[
        : len(cell.key)
    ]
    column = f"{cell.column}, {said}" if cell.column else said
    return replace(cell, column=column, order=order, key=key, around=())


# --- the factors of a cell -----------------------------------------------------------------------


def factors_around(
    order: Order, loaded: LoadedMission, wanted: Margins
) -> tuple[MarginFactor, ...]:
    """Return the factors that are changed round a cell.

    Raises:
        UsageError: There is no such factor, or its range does not fit; says which.
    """
    profile = simulated_profile(loaded.loaded_robot.profile, order.twin, 0, order.numbers)
    nominal = _nominal(profile, loaded)
    defects = profile.simulation.defects
    asked: dict[str, tuple[str, str] | None] = {}
    for name, ends in (wanted.factors or dict.fromkeys(_usual(nominal, profile))).items():
        if name.startswith(_EACH):
            key = name.removeprefix(_EACH)
            taking = [d for d, each in defects.items() if key in keys_of_defect(each.kind)]
            asked |= {f"{defect}:{key}": ends for defect in taking}
        asked |= {} if name.startswith(_EACH) else {name: ends}
    for defect in order.defects:
        for name in asked:
            if name.partition(":")[0] == defect.partition(":")[0]:
                raise UsageError(f"{name}: the cell has this defect already: leave one of them out")
    plain = [name for name in asked if ":" not in name]
    if wrong := unknown("there is no factor", plain, nominal):
        raise UsageError(wrong)
    found = [
        _of_defect(name, ends, profile) if ":" in name else _of_number(name, ends, nominal[name])
        for name, ends in asked.items()
    ]
    for factor in found:
        _check_ends(factor, loaded, profile)
    return tuple(found)


def _check_ends(factor: MarginFactor, loaded: LoadedMission, profile: Profile) -> None:
    """Check that the pipe or the robot can have both ends of a range, as a run would."""
    assert loaded.pipe is not None
    for end in (factor.low, factor.high) if ":" not in factor.name else ():
        name = f"{OF_PIPE}{factor.name}" if factor.name in PIPE_NUMBERS else factor.name
        numbers = {name: factor.written(end).replace(" ", "")}
        simulated_profile(profile, None, 0, numbers)
        if name != factor.name:
            changed_pipe(loaded.pipe, profile, numbers, {})


def _usual(nominal: Mapping[str, tuple[float, str]], profile: Profile) -> Iterator[str]:
    """Yield the names of the factors of a campaign that names none."""
    yield from (name for name in PIPE_NUMBERS if name in _USUAL_WAYS or nominal[name][0])
    usual = ("stall_torque", "no_load_speed", "angle", "detector")
    for name, (value, _) in nominal.items():
        if name.startswith(("motors.", "noise.")) and name.endswith(usual) and value > 0.0:
            yield name
    for name, defect in profile.simulation.defects.items():
        if defect.kind in _USUAL_KINDS:
            yield f"{name}:share"


def _nominal(profile: Profile, loaded: LoadedMission) -> dict[str, tuple[float, str]]:
    """Return the value and the unit of each number that can be changed."""
    assert loaded.pipe is not None  # an order without a pipe has been refused
    found = {
        name: (value, unit_of(PIPE_NUMBERS[name].dimension))
        for name, value in numbers_of(loaded.pipe, profile).items()
    }
    groups = {f"motors.{kind}": motor for kind, motor in profile.motors.items()}
    units = {
        "no_load_speed": "rad/s",
        "stiffness": "Nm/rad",
        **dict.fromkeys(("stall_torque", "hold_torque", "dead_drag"), "Nm"),
    }
    for group, motor in groups.items():
        for key in PARTS_OF_A_TWIN["motors"].model_fields:
            value = getattr(motor, key, None)
            if value is not None:
                found[f"{group}.{key}"] = value, units[key]
    units = {"angle": "rad", "current": "A", "acceleration": "m/s^2", "detector": "m"}
    for key in PARTS_OF_A_TWIN["noise"].model_fields:
        found[f"noise.{key}"] = getattr(profile.simulation.noise, key), units[key]
    found["tyre.rolling_resistance"] = profile.simulation.tyre.rolling_resistance, ""
    return found


def _of_number(name: str, ends: tuple[str, str] | None, nominal: tuple[float, str]) -> MarginFactor:
    value, unit = nominal
    if name == "friction" and not value:
        raise UsageError(f"{name}: it is 0 in the files, which cannot be scaled")
    if ends is not None:
        dimension = parse_quantity(f"1 {unit}".strip()).dimension if unit else DIMENSIONLESS
        low, high = (_read(name, each, dimension) for each in ends)
    elif name in _USUAL_WAYS:
        low, high = value - _USUAL_WAYS[name], value + _USUAL_WAYS[name]
        _, least, most = PIPE_NUMBERS[name]
        low, high = max(low, least), min(high, most)
    else:
        least, most = _USUAL_RANGES[name.partition(".")[0]]
        low, high = least * value, most * value or _USUAL_FROM_ZERO.get(name, 0.0)
        if not high:
            raise UsageError(f"{name}: give a range: its value in the files is 0")
    return _checked(MarginFactor(name, READ_IN.get(unit, unit), low, high, value))


def _of_defect(name: str, ends: tuple[str, str] | None, profile: Profile) -> MarginFactor:
    """Return the factor of a number of a defect, which the files do not have."""
    defect, _, key = name.partition(":")
    defects = profile.simulation.defects
    if wrong := unknown("there is no defect", [defect], defects):
        raise UsageError(wrong)
    takes = keys_of_defect(defects[defect].kind)
    if wrong := unknown(f"the defect {defect} takes no number", [key], takes):
        raise UsageError(wrong)
    most = DEFECT_KEYS[key].most
    if ends is None and most > 1.0:
        raise UsageError(f"{name}: say from where to where, such as '{name}=0 s..60 s'")
    given = ends or ("0", f"{most:g}")
    for each in given:
        named([f"{defect}:{key}={each.replace(' ', '')}"], profile, 0)
    first, last = (parse_quantity(each) for each in given)
    # A defect does least if it begins late and comes rarely, else if its number is small.
    nominal = last.value if key in ("after", "every") else first.value
    unit = unit_of(last.dimension)
    ends_at = first.value, last.value, nominal
    added = bool(nominal) or key not in _NOTHING
    return _checked(MarginFactor(name, READ_IN.get(unit, unit), *ends_at, added))


def _read(name: str, text: str, dimension: Dimension) -> float:
    try:
        return read_quantity(text, dimension)
    except QuantityError as error:
        raise UsageError(f"{name}: {error}") from None


def _checked(factor: MarginFactor) -> MarginFactor:
    if not factor.low <= factor.nominal <= factor.high or factor.low == factor.high:
        low, high, nominal = map(factor.written, (factor.low, factor.high, factor.nominal))
        raise UsageError(
            f"{factor.name}: the range {low} to {high} must have the value of the files, {nominal}"
        )
    return factor


def bound_of(factor: MarginFactor, text: str) -> float:
    """Return the value of a bound that is written with its unit.

    Raises:
        UsageError: It is not a value of this factor, or beyond its range.
    """
    with suppress(QuantityError):
        value = parse_quantity(text)
        unit = unit_of(value.dimension)
        fits = READ_IN.get(unit, unit) == factor.unit
        if fits and factor.low <= value.value <= factor.high:
            return value.value
    low, high = factor.written(factor.low), factor.written(factor.high)
    raise UsageError(f"{factor.name}: expected a bound from {low} to {high}, got '{text}'")


def check_bound(factor: MarginFactor, bound: MarginBound) -> None:
    """Check that runs can miss a bound.

    Raises:
        UsageError: It is not a value of this factor, beyond its range, or on the wrong side.
    """
    at, nominal = factor.rounded(bound_of(factor, bound.text)), factor.rounded(factor.nominal)
    if at > nominal if bound.side == ">=" else at < nominal:
        other = "<=" if bound.side == ">=" else ">="
        raise UsageError(
            f"{factor.name}: '{bound.side} {bound.text}' says nothing, as the margin begins at "
            f"{factor.written(nominal)}: write '{other} {bound.text}', that it must hold as far "
            "as that"
        )

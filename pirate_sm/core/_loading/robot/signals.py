"""Look up the signals of a robot by name."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import Literal

from pirate_sm.core._engine.sensing.board_spec import LinkSpec, WheelSpec
from pirate_sm.core._expressions import (
    EnumType,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_expression,
)
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model import profile as model
from pirate_sm.core.spelling import nearest
from pirate_sm.core.units import DIMENSIONLESS, Dimension

_NOTHING = Vocabulary({})


@dataclass
class Signals:
    """The robot's vocabulary, with the data for computing it from frames.

    Attributes:
        vocabulary: Its words begin with the regions, so a configuration is a prefix of the words.
        scales: Factor to SI of each conversion.
    """

    profile: model.Profile
    problems: Problems
    polarity: Literal["normal", "mirrored"]
    vocabulary: Vocabulary = _NOTHING
    scales: dict[str, tuple[float, Dimension]] = field(default_factory=dict)
    wheels: tuple[WheelSpec, ...] = ()

    @property
    def link(self) -> LinkSpec:
        """Return the timing of the link."""
        link = self.profile.link
        return LinkSpec(
            link.cycle * self.profile.messages_per_round,
            link.stale_after,
            link.silent_after,
            link.resend_after,
            link.resend_limit,
        )

    def number(self, name: str, path: Path, dimension: Dimension | None = None) -> int:
        """Return the index of a numeric signal; -1 after reporting an unknown name."""
        names, types = self.vocabulary.numbers, self.vocabulary.types
        if name not in names:
            fit = [each for each in names if dimension and types[each] == NumberType(dimension)]
            if path[0] == "body":  # each of its signals is of one wheel or joint
                fit = [each for each in fit if each not in self._of_body]
            self.problems.add(
                "robot.signal",
                path,
                f"there is no signal '{name}'",
                suggestion=nearest(name, fit if dimension else names) or "",
            )
            return -1
        kind = types[name]
        if dimension is not None and kind != NumberType(dimension):
            self.problems.add(
                "robot.signal", path, f"'{name}' is {kind}", expected=str(NumberType(dimension))
            )
        return names.index(name)

    @property
    def _of_body(self) -> set[str | None]:
        """Return the signals that the body names."""
        body = self.profile.body
        of_wheels = {each for wheel in body.wheels for each in (wheel.angle, wheel.speed)}
        of_joints = {each for joint in body.joints for each in (joint.name, joint.torque)}
        return of_wheels | of_joints | {link.roll for link in body.links}

    def constant(self, text: str, path: Path) -> tuple[float, Dimension]:
        """Return the SI value and dimension of a constant expression such as ``360 deg / 4096``."""
        try:
            expression = compile_expression(text, _NOTHING)
        except ExpressionError as error:
            self.problems.add_expression(path, error)
            return 0.0, DIMENSIONLESS
        if not isinstance(expression.type, NumberType):
            self.problems.add("robot.scale", path, "expected a number with a unit")
            return 0.0, DIMENSIONLESS
        value = expression.evaluate((), ())
        if fault := _no_scale(value):
            self.problems.add("robot.scale", path, f"'{text}' {fault}")
            return 0.0, expression.type.dimension
        assert value is not None
        return value, expression.type.dimension

    def first_of(self, kind: str) -> int:
        """Return the index of the first derived signal of this kind; -1 without one."""
        for name, derived in self.profile.derived.items():
            if hasattr(derived, kind):
                return self.vocabulary.numbers.index(name)
        return -1

    def rate_of(self, name: str) -> int:
        """Return the index of the signal that is this one's rate; -1 without one."""
        for rate, derived in self.profile.derived.items():
            if isinstance(derived, kinds.RateOf) and derived.rate_of == name:
                return self.vocabulary.numbers.index(rate)
        return -1


def _no_scale(value: float | None) -> str:
    """Return why a number cannot be a scale; empty if it can be one.

    Simulators divide by scales, to get the counts that a sensor shows.
    """
    if value is None:
        return "divides by zero"
    if value == 0:
        return "is zero: every count would mean the same"
    return "" if isfinite(value) and isfinite(1 / value) else "is too large or too small"


def check_name(
    name: str, kind: NumberType | EnumType, path: Path, problems: Problems, *, key: bool = False
) -> None:
    """Report a name that conditions cannot use."""
    try:
        Vocabulary({name: kind})
    except ValueError as error:
        problems.add("robot.name", path, str(error), key=key)

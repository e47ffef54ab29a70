"""The range of each signal, and where in it a comparison of the signal changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import combinations, pairwise
from math import inf, isfinite, pi, sqrt
from typing import NamedTuple

from pirate_sm.core import models as model
from pirate_sm.core.expressions import change_of, tree
from pirate_sm.core.robot import RobotSpec

_COUNTS = 2**15
"""The wire carries int16 values (PICO boards, thesis section 4-2)."""


class Range(NamedTuple):
    """The smallest and the largest value in SI units."""

    low: float = -inf
    high: float = inf


ANYTHING = Range()


def ranges(profile: model.Profile, robot: RobotSpec) -> Mapping[str, Range]:
    """Return the ranges of numeric signals; a signal without one is unlimited."""
    names = robot.vocabulary.numbers
    found: dict[str, Range] = {}
    for board in robot.boards.values():
        for _, target, scale in board.channels:
            found[names[target]] = Range(-_COUNTS * abs(scale), _COUNTS * abs(scale))
        for number, low, high in board.watched.ranges:  # what is beyond counts as unknown
            wire = found.get(names[number], ANYTHING)
            found[names[number]] = Range(max(low, wire.low), min(high, wire.high))
        for each in board.derived:
            of = [found.get(names[source], ANYTHING) for source in each.sources]
            found[names[each.target]] = _derived(each.how, each.constants, of)
    found |= dict(_of_body(profile, robot))
    changes = {change_of(n): Range(r.low - r.high, r.high - r.low) for n, r in found.items()}
    return found | changes


def _of_body(profile: model.Profile, robot: RobotSpec) -> Iterator[tuple[str, Range]]:
    """Yield the ranges of the angles of joints, and of the bound of the odometry."""
    names = robot.vocabulary.numbers
    for joint in profile.body.joints:
        if joint.name in names:
            yield joint.name, Range(-joint.end_stop, joint.end_stop)
    if robot.bound >= 0:
        yield names[robot.bound], Range(0.0)


def _derived(how: str, constants: Sequence[float], of: Sequence[Range]) -> Range:
    """Return the range of what an operation makes of numbers of these ranges."""
    match how:
        case "torque":
            most = abs(constants[0]) * of[0].high
            return Range(-most, most)
        case "norm":
            return Range(0.0, sqrt(sum(each.high**2 for each in of)))
        case "roll":
            return Range(-pi, pi)
        case "pitch":
            return Range(-pi / 2, pi / 2)
        case "diameter":  # eq. 3-2
            leg_m, more_m = constants
            return Range(more_m, leg_m + more_m)
        case _:
            return ANYTHING


# --- piecewise linear ----------------------------------------------------------------------------


_FAR = 1e9
"""Bound of an unlimited range; no signal of a robot comes near it in SI units."""


def signals(node: tree.Node) -> tuple[str, ...]:
    """Return the distinct names of the numeric signals in a node, in the order of the text."""
    found = (each for each in tree.walk(node) if isinstance(each, tree.Signal))
    return tuple(dict.fromkeys(each.name for each in found if each.kind == "number"))


def is_linear(node: tree.Node) -> bool:
    """Return whether a number is a piecewise linear function of its signals."""
    match node:
        case tree.Arithmetic("*", left, right):
            linear = not (signals(left) and signals(right))
        case tree.Arithmetic("/", _, right):
            linear = not signals(right)
        case _:
            linear = True
    return linear and all(is_linear(child) for child in tree.children(node))


def value(node: tree.Node, x: float) -> float:
    """Return the value of a number whose only signal is ``x``."""
    match node:
        case tree.Number(number):
            return number
        case tree.Signal():
            return x
        case tree.Negate(operand):
            return -value(operand, x)
        case tree.Arithmetic(operator, left, right):
            return _arithmetic(operator, value(left, x), value(right, x))
        case tree.Call(function, arguments):
            numbers = [value(each, x) for each in arguments]
            return abs(numbers[0]) if function == "abs" else _EXTREMES[function](numbers)
        case _:
            raise AssertionError(f"{node} is no number")


def span_of(node: tree.Node, spans: Mapping[str, Range]) -> Range:
    """Return a range of a number whose signals may have any values of their ranges."""
    match node:
        case tree.Number(number):
            return Range(number, number)
        case tree.Signal(name):
            return spans.get(name, ANYTHING)
        case tree.Negate(operand):
            low, high = span_of(operand, spans)
            return Range(-high, -low)
        case tree.Arithmetic("+" | "-" as operator, left, right):
            one, other = span_of(left, spans), span_of(right, spans)
            if operator == "-":
                other = Range(-other.high, -other.low)
            return Range(one.low + other.low, one.high + other.high)
        case tree.Call(function, arguments):
            lows, highs = zip(*(span_of(each, spans) for each in arguments), strict=True)
            if function == "abs":
                return Range(max(0.0, lows[0], -highs[0]), max(-lows[0], highs[0]))
            return Range(_EXTREMES[function](lows), _EXTREMES[function](highs))
        case _:
            return ANYTHING


_EXTREMES = {"min": min, "max": max}


def _arithmetic(operator: tree.ArithmeticOperator, left: float, right: float) -> float:
    match operator:
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
        case "/":
            return left / right if right else inf


def _kinks(node: tree.Node, span: Range) -> set[float]:
    """Return the points at which the slope of the number may change."""
    found: set[float] = set()
    for child in tree.children(node):
        found |= _kinks(child, span)
    if isinstance(node, tree.Call):
        if node.function == "abs":
            found |= _roots(node.arguments[0], found, span)
        else:
            for first, second in combinations(node.arguments, 2):
                found |= _roots(tree.Arithmetic("-", first, second), found, span)
    return found


def _roots(node: tree.Node, kinks: Iterable[float], span: Range) -> set[float]:
    """Return the roots of the number between the given kinks."""
    points = sorted({max(span.low, -_FAR), min(span.high, _FAR), *kinks})
    found = set()
    for a, b in pairwise(points):
        at_a, at_b = value(node, a), value(node, b)
        if at_a == 0:
            found.add(a)
        if at_b == 0:
            found.add(b)
        if at_a * at_b < 0 and isfinite(at_a) and isfinite(at_b):
            found.add(a - at_a * (b - a) / (at_b - at_a))
    return found


@lru_cache(maxsize=4096)
def borders(compare: tree.Compare, span: Range) -> frozenset[float]:
    """Return the values of the only signal at which the comparison may change."""
    difference = tree.Arithmetic("-", compare.left, compare.right)
    kinks = _kinks(difference, span)
    found = kinks | _roots(difference, kinks, span)
    for side, other in ((compare.left, compare.right), (compare.right, compare.left)):
        if isinstance(side, tree.Signal) and not signals(other):
            found.add(value(other, 0.0))  # avoids the rounding of an interpolation
    return frozenset(found)


def samples(marks: Iterable[float], span: Range) -> tuple[float, ...]:
    """Return each border and a value on either side of it, within the range."""
    inside = sorted({mark for mark in marks if span.low <= mark <= span.high})
    low, high = max(span.low, -_FAR), min(span.high, _FAR)
    if not inside:
        return ((low + high) / 2,) if low > -_FAR and high < _FAR else (min(max(0.0, low), high),)
    found = [*inside]
    found += [(a + b) / 2 for a, b in pairwise(inside)]
    found += [max(low, inside[0] - _step(inside[0])), min(high, inside[-1] + _step(inside[-1]))]
    return tuple(dict.fromkeys(found))


def _step(near: float) -> float:
    """Return a step beyond the outermost border of suitable size."""
    return max(abs(near), 0.1)

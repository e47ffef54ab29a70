"""The criteria of completed commands as conditions, as :mod:`pirate_sm.engine.robot.done` has them.

A condition is true where :func:`~pirate_sm.engine.robot.done.holds` is, and false or unknown
elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable

from pirate_sm.engine.control.position_loop import PositionLoop
from pirate_sm.engine.robot.criteria import (
    AcceptedSpec,
    AlignedSpec,
    BelowSpec,
    CriterionSpec,
    ReachedSpec,
    StalledSpec,
    StoppedSpec,
    TurningSpec,
)
from pirate_sm.expressions import tree

Numbers = tuple[float, ...]
Seekers = tuple[PositionLoop, ...]


def criterion_tree(criterion: CriterionSpec, setpoints: Numbers, seekers: Seekers) -> tree.Node:
    """Return the criterion as a condition on the signals.

    Args:
        criterion: The criterion.
        setpoints: Setpoints in force.
        seekers: The running position loops; no other loop runs.
    """
    match criterion:
        case AcceptedSpec():
            return tree.TruthValue(True)
        case StalledSpec():
            still = [_within(rate, "<", criterion.still) for rate in criterion.rates]
            loads = [_beyond(it.torque, it.needed_nm(setpoints)) for it in criterion.loads]
            return all_of([*still, *loads])
        case ReachedSpec():
            return all_of(_reached(criterion, setpoints, loop) for loop in seekers)
        case TurningSpec():
            return any_of(
                tree.Compare(">", _signed(speed, setpoints[slot]), tree.Number(criterion.above))
                for slot, speed in criterion.wheels
                if setpoints[slot] != 0
            )
        case StoppedSpec():
            return all_of(_still(speeds, criterion.below) for speeds in criterion.parts)
        case AlignedSpec():
            return all_of(
                tree.Compare("<=", _off(setpoints[slot], angle), tree.Number(criterion.within))
                for slot, angle in criterion.slots
            )
        case BelowSpec():
            return all_of(_within(signal, "<", criterion.limit) for signal in criterion.signals)


def arrived_tree(loop: PositionLoop) -> tree.Node:
    """Return whether the loop's joint is at its angle, as a condition."""
    return near(loop.target_rad, loop.angle, loop.spec.threshold_rad)


def near(target: float, signal: int, within: float) -> tree.Node:
    """Return whether a signal is at most this far from a value, as a condition."""
    return tree.Compare("<=", _off(target, signal), tree.Number(within))


def all_of(parts: Iterable[tree.Node]) -> tree.Node:
    """Return the condition that all these hold."""
    return tree.And(tuple(parts))


def any_of(parts: Iterable[tree.Node]) -> tree.Node:
    """Return the condition that one of these holds."""
    return tree.Or(tuple(parts))


def number(index: int) -> tree.Signal:
    """Return the signal with this index."""
    return tree.Signal("", "number", index)


def size_of(operand: tree.Node) -> tree.Node:
    """Return the magnitude of a number."""
    return tree.Call("abs", (operand,))


def _reached(criterion: ReachedSpec, setpoints: Numbers, loop: PositionLoop) -> tree.Node:
    duty, arrived = setpoints[loop.slot], arrived_tree(loop)
    if duty == 0:
        return arrived
    pushed_nm = loop.pushed_nm(duty, criterion.loaded, criterion.least_nm)
    pushed = tree.Compare(">", _signed(loop.torque, duty), tree.Number(pushed_nm))
    return any_of((arrived, all_of((_within(loop.rate, "<", criterion.still), pushed))))


def _still(speeds: tuple[int, ...], below: float) -> tree.Node:
    """Return whether at least one wheel reports and all reporting wheels turn slower."""
    known = [tree.Known(number(speed)) for speed in speeds]
    slow = [any_of((tree.Not(tree.Known(number(s))), _within(s, "<", below))) for s in speeds]
    return all_of((any_of(known), *slow))


def _within(signal: int, operator: tree.CompareOperator, limit: float) -> tree.Node:
    return tree.Compare(operator, size_of(number(signal)), tree.Number(limit))


def _beyond(signal: int, limit: float) -> tree.Node:
    return _within(signal, ">", limit)


def _off(target: float, signal: int) -> tree.Node:
    return size_of(tree.Arithmetic("-", tree.Number(target), number(signal)))


def _signed(signal: int, setpoint: float) -> tree.Node:
    """Return a signal, positive in the direction of a setpoint other than zero."""
    return number(signal) if setpoint > 0 else tree.Negate(number(signal))

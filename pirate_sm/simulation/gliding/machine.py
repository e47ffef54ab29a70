"""The stack machine of :mod:`pirate_sm.core.expressions` in compiled code."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled

# The instructions, as in `core/_expressions/bytecode.py`: numbers, which numba takes as constants.
CONSTANT, NUMBER, NEGATE, ABSOLUTE, KNOWN, NOT, ADD, SUBTRACT, MULTIPLY, DIVIDE = range(10)
EQUAL, DIFFERENT, LESS, AT_MOST, GREATER, AT_LEAST, LEAST, GREATEST, ALL, ANY = range(10, 20)

# Columns of the code.
OPERATION, ARGUMENT = range(2)


@compiled
def _compared(operation: int, left: float, right: float) -> float:
    if np.isnan(left) or np.isnan(right):
        return np.nan
    if operation == EQUAL:
        holds = left == right
    elif operation == DIFFERENT:
        holds = left != right
    elif operation == LESS:
        holds = left < right
    elif operation == AT_MOST:
        holds = left <= right
    elif operation == GREATER:
        holds = left > right
    else:
        holds = left >= right
    return 1.0 if holds else 0.0


@compiled
def _calculated(operation: int, left: float, right: float) -> float:
    if operation == ADD:
        return left + right
    if operation == SUBTRACT:
        return left - right
    if operation == MULTIPLY:
        return left * right
    return left / right if right != 0.0 else np.nan


@compiled
def _changed(operation: int, value: float) -> float:
    if operation == KNOWN:
        return 0.0 if np.isnan(value) else 1.0
    if operation == NEGATE:
        return -value
    if operation == ABSOLUTE:
        return abs(value)
    return np.nan if np.isnan(value) else 1.0 - value


@compiled
def _joined(operation: int, values: Floats) -> float:
    """Return the least, the greatest, or whether all or any of several values are true."""
    deciding = 0.0 if operation == ALL else 1.0
    result = values[0]
    unknown = False
    for value in values:
        unknown = unknown or np.isnan(value)
        if operation == LEAST:
            result = value if value < result else result
        elif operation == GREATEST:
            result = value if value > result else result
        elif value == deciding:
            return deciding
    if unknown:
        return np.nan
    return result if operation < ALL else 1.0 - deciding


@compiled
def value_of(
    code: Floats, begin: int, end: int, numbers: Floats, origin: Floats, stack: Floats
) -> float:
    """Return the value of a condition: 1 true, 0 false, NaN unknown; or that of a number.

    Args:
        code: `(instructions, 2)`: operation and argument.
        begin: The first instruction.
        end: The instruction after the last.
        numbers: Signals, SI; NaN is unknown.
        origin: Signals when the wait began; the change of a signal has its index after all signals.
        stack: Scratch; as deep as the code needs.
    """
    count = numbers.shape[0]
    top = -1
    for at in range(begin, end):
        operation = int(code[at, OPERATION])
        if operation == CONSTANT:
            top += 1
            stack[top] = code[at, ARGUMENT]
        elif operation == NUMBER:
            top += 1
            index = int(code[at, ARGUMENT])
            if index < count:
                stack[top] = numbers[index]
            else:
                stack[top] = numbers[index - count] - origin[index - count]
        elif operation < ADD:
            stack[top] = _changed(operation, stack[top])
        elif operation < EQUAL:
            top -= 1
            stack[top] = _calculated(operation, stack[top], stack[top + 1])
        elif operation < LEAST:
            top -= 1
            stack[top] = _compared(operation, stack[top], stack[top + 1])
        else:
            top -= int(code[at, ARGUMENT]) - 1
            stack[top] = _joined(operation, stack[top : top + int(code[at, ARGUMENT])])
    return float(stack[0])

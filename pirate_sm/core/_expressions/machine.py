"""The stack machine that runs the code of conditions where no Python function can be called.

All its values are floats: a condition is 1 (true), 0 (false) or NaN (unknown), an unknown number is
NaN. It gives what the function of a condition gives, to the bit. This is plain Python, and the
simulator compiles it (:func:`pirate_sm.simulation.machine_code.compiled_module`), so a function
comes after those that it calls.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan

CONSTANT, NUMBER, NEGATE, ABSOLUTE, KNOWN, NOT, ADD, SUBTRACT, MULTIPLY, DIVIDE = range(10)
EQUAL, DIFFERENT, LESS, AT_MOST, GREATER, AT_LEAST, LEAST, GREATEST, ALL, ANY = range(10, 20)
"""The instructions: those that push a value (NUMBER: a signal, by its index), that change one, that
take two, and that take as many as their argument says."""

DEEPEST = 32
"""How many values the machine can remember."""


def changed(operation: int, value: float) -> float:
    """Return what an operation makes of one value."""
    if operation == KNOWN:
        return 0.0 if isnan(value) else 1.0
    if operation == NEGATE:
        return -value
    if operation == ABSOLUTE:
        return abs(value)
    return nan if isnan(value) else 1.0 - value


def calculated(operation: int, left: float, right: float) -> float:
    """Return what an arithmetic operation makes of two numbers."""
    if operation == ADD:
        return left + right
    if operation == SUBTRACT:
        return left - right
    if operation == MULTIPLY:
        return left * right
    return left / right if right != 0.0 else nan


def compared(operation: int, left: float, right: float) -> float:
    """Return whether a comparison of two numbers is true."""
    if isnan(left) or isnan(right):
        return nan
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


def joined(operation: int, values: Sequence[float]) -> float:
    """Return the least, the greatest, or whether all or any of several values are true."""
    deciding = 0.0 if operation == ALL else 1.0
    result = values[0]
    unknown = False
    for value in values:
        unknown = unknown or isnan(value)
        if operation == LEAST:
            result = value if value < result else result
        elif operation == GREATEST:
            result = value if value > result else result
        elif value == deciding:
            return deciding
    if unknown:
        return nan
    return result if operation < ALL else 1.0 - deciding


def value_of(
    code: Sequence[Sequence[float]],
    begin: int,
    end: int,
    numbers: Sequence[float],
    origin: Sequence[float],
    stack: list[float],
) -> float:
    """Return the value of a condition: 1 true, 0 false, NaN unknown; or that of a number.

    Args:
        code: Instructions, each with its argument.
        begin: The first instruction.
        end: The instruction after the last.
        numbers: Signals, SI; NaN is unknown.
        origin: Signals when the wait began; the change of a signal has its index after all signals.
        stack: Memory; as deep as the code needs, see :data:`DEEPEST`.
    """
    count = len(numbers)
    top = -1
    for at in range(begin, end):
        operation, argument = int(code[at][0]), code[at][1]
        if operation == CONSTANT:
            top += 1
            stack[top] = argument
        elif operation == NUMBER:
            top += 1
            index = int(argument)
            if index < count:
                stack[top] = numbers[index]
            else:
                stack[top] = numbers[index - count] - origin[index - count]
        elif operation < ADD:
            stack[top] = changed(operation, stack[top])
        elif operation < EQUAL:
            top -= 1
            stack[top] = calculated(operation, stack[top], stack[top + 1])
        elif operation < LEAST:
            top -= 1
            stack[top] = compared(operation, stack[top], stack[top + 1])
        else:
            top -= int(argument) - 1
            stack[top] = joined(operation, stack[top : top + int(argument)])
    return stack[0]

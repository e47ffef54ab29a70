"""Calls of machine code from Python: numbers as they are, arrays by their places in memory."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import partial
from itertools import accumulate, chain
from operator import is_, itemgetter
from typing import Any, TypeVar, cast

from pirate_sm.simulation.machine_code.entry_points import ARRAYS, Argument, EntryPoint

_F = TypeVar("_F", bound=Callable[..., Any])

_NUMBERS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_int64}


def callable_from_python(entry: EntryPoint, function: Any) -> Callable[..., Any]:
    """Return a function of a library as one that takes what its Python original takes.

    Args:
        entry: Its line of the table.
        function: The C function: `int f(int64 *arrays, numbers ..., void *result)`.

    Returns:
        It raises TypeError for an array that the machine code cannot take, and RuntimeError where
        the original would raise an exception. See :func:`own_call` for its attribute ``again``.
    """
    result = _NUMBERS.get(entry.result)
    function.restype = ctypes.c_int
    function.argtypes = [ctypes.c_void_p, *(_NUMBERS[each.kind] for each in entry.numbers)]
    if result is not None:
        function.argtypes.append(ctypes.c_void_p)
    expected = len(entry.flat)
    grouped = expected > len(entry.arguments)
    arrays_of = _picker([i for i, each in enumerate(entry.flat) if each.dimensions])
    numbers_of = _picker([i for i, each in enumerate(entry.flat) if not each.dimensions])
    places = _Places(entry)

    def call(*arguments: Any) -> Any:
        if grouped:
            arguments = tuple(chain.from_iterable(_members(each) for each in arguments))
        if len(arguments) != expected:
            raise TypeError(f"{entry.name} takes {expected} arguments, not {len(arguments)}")
        block = places.of(arrays_of(arguments))
        out = None
        if result is None:
            status = function(block, *numbers_of(arguments))
        else:
            out = result()
            status = function(block, *numbers_of(arguments), ctypes.byref(out))
        if status:
            raise RuntimeError(f"{entry.name} failed: out of memory, or shapes that do not fit")
        if out is not None:
            return bool(out.value) if entry.result == "bool" else out.value

    call.again = partial(callable_from_python, entry, function)  # type: ignore[attr-defined]
    return call


def _members(argument: Any) -> tuple[Any, ...]:
    return argument if isinstance(argument, tuple) else (argument,)


def own_call(function: _F) -> _F:
    """Return a compiled function for one caller among many.

    It remembers that caller's arrays, where the function itself would look at all of them again
    whenever another caller has come between.
    """
    again = getattr(function, "again", None)
    return function if again is None else cast(_F, again())


def _picker(positions: Sequence[int]) -> Callable[[Sequence[Any]], tuple[Any, ...]]:
    """Return a function that returns the items at these positions."""
    if len(positions) > 1:
        return itemgetter(*positions)
    return lambda items: tuple(items[position] for position in positions)


class _Places:
    """The places in memory of the arrays of a function's last call.

    A run calls with the same arrays all the time, so only one that was not there last time is
    looked at. What is remembered is replaced as a whole: threads do not disturb each other.
    """

    def __init__(self, entry: EntryPoint) -> None:
        self._entry = entry
        self._kinds = [each for each in entry.flat if each.dimensions]
        lengths = [1 + kind.dimensions for kind in self._kinds]
        self._starts = [0, *accumulate(lengths)]
        block = (ctypes.c_int64 * self._starts[-1])()
        # The arrays are kept, so that their places stay theirs.
        self._last: tuple[tuple[Any, ...], Any] = (None,) * len(lengths), block

    def of(self, arrays: tuple[Any, ...]) -> Any:
        """Return a block with the address and then the shape of each array.

        Raises:
            TypeError: One is not what the machine code takes.
        """
        known, block = self._last
        if all(map(is_, arrays, known)):
            return block
        block = type(block).from_buffer_copy(block)
        for i, (kind, array, old) in enumerate(zip(self._kinds, arrays, known, strict=True)):
            if array is not old:
                if not _fits(kind, array):
                    raise TypeError(self._wanted(i))
                start, end = self._starts[i : i + 2]
                block[start:end] = (_address(array), *array.shape)
        self._last = arrays, block
        return block

    def _wanted(self, index: int) -> str:
        kind = self._kinds[index]
        number = [i for i, each in enumerate(self._entry.flat, 1) if each.dimensions][index]
        return (
            f"argument {number} of {self._entry.name} must be {kind.kind} of {kind.dimensions} "
            "dimension(s), contiguous in C order, that can be written to"
        )


def _fits(kind: Argument, array: Any) -> bool:
    return bool(
        array.ndim == kind.dimensions
        and array.dtype.char in ARRAYS[kind.kind].letters
        and array.dtype.isnative
        and array.flags.carray
    )


def _address(array: Any) -> int:
    # numpy's own ways to say it take five times as long.
    return ctypes.addressof(ctypes.c_char.from_buffer(array)) if array.size else 0

"""Calls of machine code from Python: what it takes and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pirate_sm.simulation.machine_code.built_library import (
    callable_from_python,
    find_library,
    own_call,
)
from pirate_sm.simulation.machine_code.entry_points import ENTRY_POINTS, entry_point

FOUND = find_library()
built = pytest.mark.skipif(FOUND.library is None, reason=f"no library here: {FOUND.why_not}")

DIGITIZE = next(entry for entry in ENTRY_POINTS if entry.name == "digitize")
SHOWN = 0
CHANNELS = np.array([[SHOWN, 2.0, 1.0, 0.0, 0.0], [SHOWN, -2.0, 0.0, 0.0, 1.0]])


@pytest.fixture
def digitize() -> Callable[..., Any]:
    assert FOUND.library is not None
    return FOUND.library.function(DIGITIZE)


@built
def test_a_function_reads_and_writes_the_arrays_that_it_is_given(digitize: Any) -> None:
    counts, rng = np.zeros(2), np.zeros(1, np.uint64)
    digitize(CHANNELS, 0, 2, np.array([21.0]), counts, rng)
    assert counts.tolist() == [43.0, 42.0]

    digitize(CHANNELS, 1, 2, np.array([1.0]), counts, rng)
    assert counts.tolist() == [43.0, 2.0]


@built
def test_other_arrays_than_last_time_are_noticed(digitize: Any) -> None:
    first, second, rng = np.zeros(2), np.zeros(2), np.zeros(1, np.uint64)
    for counts, shown in ((first, 1.0), (second, 2.0), (first, 3.0)):
        digitize(CHANNELS, 0, 2, np.array([shown]), counts, rng)

    assert (first.tolist(), second.tolist()) == ([7.0, 6.0], [5.0, 4.0])


@built
@pytest.mark.parametrize(
    ("position", "wrong"),
    [
        (0, np.zeros(5)),
        (0, np.zeros((2, 5), order="F")),
        (0, np.zeros((4, 5))[::2]),
        (3, np.zeros(1, np.float32)),
        (3, np.zeros(1, ">f8")),
        (5, np.zeros(1, np.int64)),
    ],
    ids=["dimensions", "order", "gaps", "element", "byte order", "sign"],
)
def test_an_array_that_the_machine_code_cannot_take_is_refused(
    digitize: Any, position: int, wrong: Any
) -> None:
    arguments = [CHANNELS, 0, 2, np.zeros(1), np.zeros(2), np.zeros(1, np.uint64)]
    arguments[position] = wrong

    with pytest.raises(TypeError, match=f"argument {position + 1} of digitize must be"):
        digitize(*arguments)


@built
def test_an_array_that_must_not_be_written_to_is_refused(digitize: Any) -> None:
    counts = np.zeros(2)
    counts.flags.writeable = False

    with pytest.raises(TypeError, match="argument 5 of digitize"):
        digitize(CHANNELS, 0, 2, np.zeros(1), counts, np.zeros(1, np.uint64))


@built
def test_too_few_arguments_are_refused(digitize: Any) -> None:
    with pytest.raises(TypeError, match="digitize takes 6 arguments, not 1"):
        digitize(CHANNELS)


class Recorded:
    """Stands in for a C function: notes what it is called with, and returns 0 or a failure."""

    def __init__(self, returns: int = 0) -> None:
        self.returns = returns
        self.blocks: list[list[int]] = []
        self.numbers: list[tuple[Any, ...]] = []

    def __call__(self, block: Any, *numbers: Any) -> int:
        self.blocks.append(list(block))
        self.numbers.append(numbers)
        return self.returns


def test_arrays_are_passed_by_address_and_shape_and_numbers_as_they_are() -> None:
    function, first, empty = Recorded(), np.ones((2, 3)), np.zeros((0, 4), np.int64)
    call = callable_from_python(entry_point("m:f", "int, Floats2, float, Ints2, bool"), function)
    call(1, first, 0.5, empty, True)

    assert function.blocks == [[first.ctypes.data, 2, 3, 0, 0, 4]]
    assert function.numbers == [(1, 0.5, True)]


def test_only_the_array_that_is_another_one_gets_another_place() -> None:
    function, first, second, third = Recorded(), np.ones(1), np.ones(2), np.ones(3)
    call = callable_from_python(entry_point("m:f", "Floats1, Floats1"), function)
    for other in (second, third, second):
        call(first, other)

    starts = [block[:2] for block in function.blocks]
    assert starts == [[first.ctypes.data, 1]] * 3
    assert [block[3] for block in function.blocks] == [2, 3, 2]


def test_a_failure_of_the_machine_code_is_an_exception() -> None:
    call = callable_from_python(entry_point("m:f", "Floats1"), Recorded(returns=1))

    with pytest.raises(RuntimeError, match="f failed"):
        call(np.zeros(1))


@pytest.mark.parametrize(("kind", "is_a"), [("int", int), ("float", float), ("bool", bool)])
def test_a_number_can_be_returned(kind: str, is_a: type) -> None:
    found = callable_from_python(entry_point("m:f", "int", kind), Recorded())(1)

    assert (found, type(found)) == (0, is_a)


def test_a_call_of_ones_own_looks_at_its_own_arrays_once() -> None:
    function, looked = Recorded(), []

    class Watched(np.ndarray):
        """An array that notes when somebody looks at its shape."""

        @property
        def shape(self) -> Any:  # type: ignore[override]
            looked.append(id(self))
            return super().shape

    first, second = np.ones(1).view(Watched), np.ones(2).view(Watched)
    shared = callable_from_python(entry_point("m:f", "Floats1"), function)
    one, other = own_call(shared), own_call(shared)
    for _ in range(3):
        one(first)
        other(second)

    assert [block[1] for block in function.blocks] == [1, 2] * 3
    assert len(looked) == 2


def test_a_function_that_is_not_built_is_everybodys_own() -> None:
    assert own_call(len) is len

"""The library in this source tree: what it takes, what it refuses, and when it is not used."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pirate_sm.simulation import digitizing
from pirate_sm.simulation.machine_code.built_library import FILE, FOLDER, Found, find_library
from pirate_sm.simulation.machine_code.entry_points import ENTRY_POINTS
from pirate_sm.simulation.machine_code.sources import PACKAGE

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


@built
def test_what_the_simulator_calls_is_the_library(digitize: Any) -> None:
    assert not hasattr(digitizing.digitize, "py_func")
    assert "fresh counts" in (digitizing.digitize.__doc__ or "")


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """The package's sources and its library, elsewhere."""
    shutil.copytree(PACKAGE, tmp_path / "pirate_sm", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "pirate_sm"


def found_in(package: Path) -> Found:
    return find_library(package / FOLDER.relative_to(PACKAGE), package)


@built
def test_a_changed_source_makes_the_library_unusable(copied: Path) -> None:
    assert found_in(copied).library is not None
    find_library.cache_clear()
    with (copied / "simulation" / "arrays.py").open("a") as file:
        file.write("# edited\n")

    assert found_in(copied).library is None
    assert "its source was changed after" in found_in(copied).why_not


def test_without_a_library_it_is_told_why(tmp_path: Path) -> None:
    assert find_library(tmp_path).why_not == (
        "its machine code was not built with this copy of pirate_sm"
    )
    find_library.cache_clear()
    (tmp_path / "not_built.txt").write_text("there was no linker\n", "utf-8")
    assert find_library(tmp_path) == Found(None, "there was no linker")


def test_a_library_of_something_else_is_not_used(tmp_path: Path) -> None:
    (tmp_path / FILE).write_bytes(b"\x7fELF, but not really")

    assert find_library(tmp_path).library is None
    assert "cannot be loaded" in find_library(tmp_path).why_not

"""The library in this source tree, and when it is not used."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pirate_sm.simulation import digitizing
from pirate_sm.simulation.machine_code.built_library import (
    FILE,
    FOLDER,
    PACKAGE,
    Found,
    find_library,
)

FOUND = find_library()
built = pytest.mark.skipif(FOUND.library is None, reason=f"no library here: {FOUND.why_not}")


@built
def test_what_the_simulator_calls_is_the_library() -> None:
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

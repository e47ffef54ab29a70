"""The object file of the compiled functions, which says what it was made of."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.simulation.machine_code.entry_points import EntryPoint


@pytest.fixture(scope="module")
def object_file() -> Any:
    """The module, which brings numba and is imported only for these tests."""
    return import_module("pirate_sm.simulation.machine_code.object_file")


def test_sources_that_change_while_they_are_compiled_do_not_fit_the_library(
    object_file: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A library of which half is new would otherwise be taken for the new sources'."""
    sources = ["as they were"]

    class Compiled:
        def __iter__(self) -> Iterator[EntryPoint]:
            sources.append("as they are")
            return iter(())

    monkeypatch.setattr(object_file, "ENTRY_POINTS", Compiled())
    monkeypatch.setattr(object_file, "digest", lambda _: sources[-1])

    object_file.write_object_file(tmp_path / "functions.o")

    assert b"as they were" in (tmp_path / "functions.o").read_bytes()

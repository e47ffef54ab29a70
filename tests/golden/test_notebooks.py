"""The notebooks of the documents show what is stored in them. `make golden` stores it anew."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from late import late

nbclient = late("nbclient")
nbformat = late("nbformat")

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def run(notebook: Any, folder: Path) -> None:
    """Run every cell in a process of its own, in this folder."""
    nbclient.NotebookClient(
        notebook,
        timeout=100,
        record_timing=False,
        coalesce_streams=True,  # a slow cell's lines come in several parts
        resources={"metadata": {"path": str(folder)}},
    ).execute()
    del notebook.metadata["language_info"]  # which Python has run it is of no interest


def shown(notebook: Any) -> list[Any]:
    return [cell.get("outputs", []) for cell in notebook.cells]


@pytest.mark.thorough
# The client asks the event loop and its sockets in ways that newer Pythons warn about.
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_shows_what_is_stored_in_it(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    stored = nbformat.read(file, as_version=4)
    fresh = nbformat.read(file, as_version=4)
    run(fresh, tmp_path)
    if os.environ.get("GOLDEN") == "write":
        nbformat.write(fresh, file)
        stored = fresh

    assert shown(fresh) == shown(stored)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_stored_with_what_it_shows_and_without_errors(file: Path) -> None:
    stored = json.loads(file.read_text("utf-8"))
    code = [cell for cell in stored["cells"] if cell["cell_type"] == "code"]

    assert [cell["execution_count"] for cell in code] == [*range(1, len(code) + 1)]
    assert not [out for cell in code for out in cell["outputs"] if out["output_type"] == "error"]

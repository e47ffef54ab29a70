"""Drawings, character by character. `make golden` writes the files anew."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
# Those among the documents are what their readers see.
DRAWINGS = {
    "docs/pictures/mitre_bend.svg": ["mitre_bend"],
    "docs/pictures/mitre_bend_marked.svg": [
        "mitre_bend",
        "--highlight=enter,prepare,pass,regrip,lost_grip",
    ],
    "docs/pictures/pirate_ii.svg": ["pirate_ii"],
    "docs/pictures/pirate_ii_side.svg": ["robot", "pirate_ii"],
    "tests/golden/graphs/within.mmd": ["docs/examples/within.yaml", "--highlight=look,nothing"],
    "tests/golden/graphs/within.dot": ["docs/examples/within.yaml", "--highlight=look,nothing"],
    "tests/golden/graphs/call.mmd": ["docs/examples/call.yaml", "--calls"],
    "tests/golden/graphs/newt.dot": ["tests/robots/newt"],
}


@pytest.mark.parametrize("drawing", DRAWINGS)
def test_the_drawing_is_as_it_was(
    drawing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    found = tmp_path / Path(drawing).name
    given = DRAWINGS[drawing]
    command = given if given[0] == "robot" else ["graph", *given]
    result = CliRunner().invoke(commands, [*command, "-o", str(found)])
    assert (result.exit_code, result.stderr) == (0, "")
    golden = ROOT / drawing
    if os.environ.get("GOLDEN") == "write":
        golden.write_text(found.read_text("utf-8"), encoding="utf-8")

    assert golden.exists(), "there is no golden drawing yet: make golden"
    assert found.read_text("utf-8") == golden.read_text("utf-8")

"""docs/explanation/thesis.md has the stored verdicts, and they are what a run gives.

`make thesis` stores them anew, `make golden` writes the page of them.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.experiments.clamp_readings import explain_clamp
from pirate_sm.lab.experiments.experiment_files import load_experiments
from pirate_sm.lab.experiments.setups import ExperimentResult, StraightPipeSetup, TractionSetup
from pirate_sm.lab.experiments.thesis_rows import ThesisRow, compared
from pirate_sm.lab.experiments.wall_contact import contact_values

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "explanation" / "thesis.md"
STORED: dict[str, Any] = json.loads(PAGE.with_suffix(".json").read_text("utf-8"))
ROBOT = ROOT / "hardware_profiles" / "pirate_ii"
PROFILE = load_robot(ROBOT).profile
SETUPS = load_experiments(ROBOT)
ROWS = [row for setup in SETUPS for row in setup.rows]


def judged(stored: dict[str, Any], row: ThesisRow) -> tuple[str, ...]:
    """Return the row with its verdict as the file says it and our stored value."""
    given = stored["ours"]
    ours = float("nan") if given is None else given
    alone = row.model_copy(update={"unit": ""})  # the stored value is in the row's unit
    (found,) = compared([alone], {row.ours: ours})
    value = found.ours_text if given is None else f"{found.ours_text} {row.unit}".rstrip()
    return (row.of, row.what, row.place, row.thesis, found.band_text, value, found.verdict_text)


def lines() -> Iterator[str]:
    """Yield the counts and the table of the page."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in STORED["counts"].items())
    yield f"{len(STORED['rows'])} rows: {counts}.\n"
    yield "| of | what | place | thesis | band | ours | verdict |"
    yield "|---|---|---|---|---|---|---|"
    known = {(row.of, row.what): row for row in ROWS}
    for stored in STORED["rows"]:
        cells = judged(stored, known[stored["of"], stored["what"]])
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
    yield ""
    yield from (f"- {note}" for note in STORED["notes"])


def test_the_page_has_every_stored_row() -> None:
    text = wanted = PAGE.read_text("utf-8")
    before, mark, rest = wanted.partition("<!-- verdicts: written by `make golden` -->\n")
    _, end, after = rest.partition("<!-- end -->")
    assert mark
    assert end
    wanted = f"{before}{mark}" + "\n".join(lines()) + f"\n{end}{after}"
    if os.environ.get("GOLDEN") == "write":
        PAGE.write_text(wanted, encoding="utf-8")
        text = wanted

    assert text == wanted


def test_every_row_of_the_files_is_stored_with_the_verdict_of_its_band() -> None:
    assert [(each["of"], each["what"]) for each in STORED["rows"]] == [
        (row.of, row.what) for row in ROWS
    ]
    for stored, row in zip(STORED["rows"], ROWS, strict=True):
        assert judged(stored, row)[-1].partition(":")[0] == stored["verdict"], row.what
    assert STORED["counts"] == Counter(each["verdict"] for each in STORED["rows"])


def verdicts(rows: list[dict[str, Any]]) -> dict[tuple[str, str], str]:
    return {(each["of"], each["what"]): each["verdict"] for each in rows}


@pytest.mark.thorough
def test_what_takes_no_run_gives_its_stored_verdicts_again() -> None:
    result = ExperimentResult()
    for setup in SETUPS:
        if isinstance(setup, TractionSetup):
            contact_values(PROFILE, setup, result)
        elif isinstance(setup, StraightPipeSetup) and setup.clamp is not None:
            explain_clamp(PROFILE, setup.clamp, 0.12, result)
    again = [each for each in compared(ROWS, result.values) if each.row.ours]

    assert len(again) > 7
    stored = {(each["of"], each["what"]): each for each in STORED["rows"]}
    for each in again:
        found = stored[each.row.of, each.row.what]
        assert found["verdict"] == each.verdict
        assert found["ours"] == pytest.approx(each.ours)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_every_experiment_gives_its_stored_verdicts_again() -> None:
    told = CliRunner().invoke(commands, ["experiment", "all", "--format", "json"])

    assert verdicts(json.loads(told.stdout)["rows"]) == verdicts(STORED["rows"])

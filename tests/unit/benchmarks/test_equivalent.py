"""The list of mutants that change nothing keeps up with the code."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from benchmarks.mutants.making import mutants_of

ROOT = Path(__file__).parents[3]
LISTED = yaml.safe_load((ROOT / "benchmarks" / "mutants" / "equivalent.yaml").read_text("utf-8"))


@pytest.mark.parametrize("entry", LISTED, ids=lambda entry: f"{entry['file']} {entry['function']}")
def test_a_listed_mutant_can_still_be_made(entry: dict[str, str]) -> None:
    file = ROOT / entry["file"]
    assert file.exists(), "the file has moved"

    made = mutants_of(entry["file"], file.read_bytes())

    changes = {(each.function, each.before, each.after) for each in made}
    assert (entry["function"], entry["before"], entry["after"]) in changes
    assert entry["reason"]

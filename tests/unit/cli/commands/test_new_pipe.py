from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("more", [(), ("--round",)])
def test_a_new_pipe_has_no_faults_and_can_be_drawn(pirate, tmp_path: Path, more) -> None:
    done = pirate("new", "pipe", "mine", *more)
    assert done.exit_code == 0
    assert (tmp_path / "pipe.schema.json").exists()
    assert pirate("check", "mine.yaml").exit_code == 0
    assert "mitre 90" in pirate("graph", "mine.yaml").stdout


def test_a_name_that_is_taken_or_none_is_refused(pirate, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("mine", encoding="utf-8")
    assert pirate("new", "pipe", "mine").exit_code == 2
    assert pirate("new", "pipe", "no name").exit_code == 2
    assert (tmp_path / "mine.yaml").read_text(encoding="utf-8") == "mine"

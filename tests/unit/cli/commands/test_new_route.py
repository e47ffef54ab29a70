from __future__ import annotations

from pathlib import Path

import pytest

U_TURN = """\
format: 1
pipe: u_turn
diameter: 120 mm
segments:
  - {straight: 1.0 m}
  - {mitre: 90 deg}
  - {straight: 1.2 m}
  - {mitre: 90 deg}
  - {straight: 1.2 m}
start: {at: 700 mm}
"""


@pytest.fixture(autouse=True)
def _with_a_pipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "u_turn.yaml").write_text(U_TURN, encoding="utf-8")


@pytest.mark.thorough
def test_the_check_accepts_a_mission_along_a_route(pirate) -> None:
    assert pirate("new", "mission", "trip", "--pipe", "u_turn").exit_code == 0
    checked = pirate("check", "trip.yaml")
    assert (checked.exit_code, checked.stderr) == (0, "")


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["own", "new", "new --round"])
def test_the_robot_arrives_at_the_end_of_the_route(pirate, pirate_run, kind: str) -> None:
    name = "u_turn" if kind == "own" else "fresh"
    if kind != "own":
        pirate("new", "pipe", *kind.split()[1:], name)
    pirate("new", "mission", "trip", "--pipe", name)
    driven = pirate_run("trip.yaml", "--speed", "max", "--no-record", "--quiet")
    assert driven.exit_code == 0
    assert "At the end of the route" in driven.output


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--route", "main"], "--route needs the pipe"),
        (["--pipe", "u_turn", "--route", "other"], "has no route 'other'"),
        (["--pipe", "u_turn", "--route", ""], "has no route ''"),
        (["--pipe", "nowhere"], "there is no pipe 'nowhere'"),
    ],
)
def test_misuse_is_told_in_a_line(pirate, tmp_path: Path, arguments, says: str) -> None:
    done = pirate("new", "mission", "trip", *arguments)
    assert done.exit_code == 2
    assert says in done.stderr
    assert not (tmp_path / "trip.yaml").exists()

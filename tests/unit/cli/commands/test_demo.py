"""The gallery: every scene ends as its file says, is listed, and stops when it is told to."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from representative import thorough_but
from typer.testing import Result

from pirate_sm.cli.commands import demo
from pirate_sm.core import library
from pirate_sm.lab.gallery.scene_file import load_scene

ROOT = Path(__file__).parents[4]
SCENES = [path.stem for path in library.scenes()]
REFUSED = """
format: 1
scene: {name}
title: A mission that is not there
look_at: The refusal
steps:
  - command: {step}
    expect: {expect}
"""


@pytest.fixture
def own(tmp_path: Path) -> Callable[..., Path]:
    """Writes a scene of one step."""

    def write(step: str, expect: str = "{}", name: str = "own") -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(REFUSED.format(name=name, step=step, expect=expect), encoding="utf-8")
        return path

    return write


def test_there_are_ten_scenes_and_each_is_listed(pirate: Callable[..., Result]) -> None:
    result = pirate("demo")

    assert result.exit_code == 0
    assert len(SCENES) == 10
    for name in SCENES:
        assert f"  {name} " in result.stdout
        assert load_scene(library.find_scene(name)).title in result.stdout


@pytest.mark.timeout(300)  # on a busy machine
@pytest.mark.parametrize("name", thorough_but({"refused"}, SCENES))
def test_a_scene_ends_as_its_file_says(
    pirate: Callable[..., Result], tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    result = pirate("demo", name, "--speed", "max", "--output", tmp_path)

    assert "✓ as expected" in result.stdout, capfd.readouterr().out + result.output
    assert result.exit_code == 0
    page = (tmp_path / name / "index.html").read_text("utf-8")
    assert "✓ as expected" in page
    for each in load_scene(library.find_scene(name)).steps:
        if "--record" in each.command:
            assert "The report of this run" in page
    assert len([*(tmp_path / name).glob("*.mcap")]) == len([*(tmp_path / name).glob("*.html")]) - 1


@pytest.mark.thorough
def test_what_a_scene_prints_can_be_run_again(
    pirate: Callable[..., Result], own: Callable[..., Path], tmp_path: Path
) -> None:
    path = own("run mitre_bend --record {out}/run.mcap", "{ended: succeeded}")
    for _ in range(2):
        result = pirate("demo", path, "--speed", "max", "--output", tmp_path / "out")

        assert result.exit_code == 0, result.output
        assert "A mission that is not there\n\nThe refusal\n" in result.stdout
        assert "\n$ pirate run mitre_bend --backend sim --speed max\n" in result.stdout
        page = (tmp_path / "out" / "own" / "index.html").read_text("utf-8")
        assert "$ pirate run mitre_bend --backend sim --speed max<" in page


@pytest.mark.thorough
def test_the_finding_of_a_refused_mission_is_printed_once(
    pirate: Callable[..., Result], tmp_path: Path
) -> None:
    result = pirate("demo", "refused", "--output", tmp_path)

    assert result.exit_code == 0, result.output
    assert result.stdout.count("error [step.impossible] RelaxRear") == 1
    assert result.stdout.count("nothing has moved") == 1


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("defect", "held", "said"),
    [
        ("bay_silent:after=33s", "true", "in truth it is not held, and carried on by 13 mm"),
        ("gamma_2_sticks", "false", "in truth it is held"),
    ],
)
def test_the_hold_at_the_end_is_judged_by_the_truth(
    pirate: Callable[..., Result],
    own: Callable[..., Path],
    tmp_path: Path,
    defect: str,
    held: str,
    said: str,
) -> None:
    code = 3 if defect.startswith("bay_silent") else 1
    step = f"run mitre_bend --defect {defect} --record {{out}}/run.mcap"
    path = own(step, f"{{exit: {code}, ended: fault, held: {held}}}")
    result = pirate("demo", path, "--speed", "max", "--output", tmp_path / "out")

    assert result.exit_code == 1
    assert f"✗ not as expected: {said}" in result.stdout


def test_a_scene_plays_for_ten_to_thirty_seconds() -> None:
    missions_s = {"bend": 29.8, "camera": 29.6, "climb": 21.9, "house": 76.2, "lost_cable": 12.1,
                  "stuck_joint": 13.0, "tee": 30.5, "twin": 76.5}  # fmt: skip
    for name, mission_s in missions_s.items():
        assert 5.0 <= mission_s / load_scene(library.find_scene(name)).speed <= 30.0, name


@pytest.mark.thorough
def test_what_ends_otherwise_is_said_and_counts(
    pirate: Callable[..., Result], own: Callable[..., Path], tmp_path: Path
) -> None:
    path = own("check nowhere.yaml", "{exit: 0, says: all is well}")
    result = pirate("demo", path, "--output", tmp_path / "out")

    assert result.exit_code == 1
    said = "✗ not as expected: exit code 2, expected 0; it does not say 'all is well'"
    assert said in result.stdout
    page = (tmp_path / "out" / "own" / "index.html").read_text("utf-8")
    assert "exit code 2, expected 0" in page
    assert "nowhere.yaml" in page


@pytest.mark.parametrize(
    ("step", "expect", "what"),
    [
        ("run mitre_bend", "{ended: failed}", "add --record {out}/run.mcap"),
        ("run x --record run.mcap", "{}", "into its own folder"),
        ("check {home}/x.yaml", "{}", "there is no folder 'home'"),
        ("check 'x", "{}", "cannot be read"),
        ("check x", "{exits: 1}", "did you mean 'exit'?"),
    ],
)
def test_faults_of_a_scene_are_named_with_their_place(
    pirate: Callable[..., Result], own: Callable[..., Path], step: str, expect: str, what: str
) -> None:
    result = pirate("demo", own(f'"{step}"', expect))

    assert result.exit_code == 2
    assert "own.yaml:" in result.stderr
    assert what in result.stderr


def test_a_scene_is_called_as_its_file(
    pirate: Callable[..., Result], own: Callable[..., Path]
) -> None:
    path = own("list robots")
    renamed = path.rename(path.with_name("other.yaml"))
    result = pirate("demo", renamed)

    assert result.exit_code == 2
    assert "the scene is called as its file: other" in result.stderr


def test_a_missing_extra_is_named_with_the_command_that_installs_it(
    pirate: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    lacking = "cv2 is not installed: pip install 'pirate-sm[vision]'"
    monkeypatch.setattr(demo, "is_missing", lambda extra: lacking if extra == "vision" else "")

    assert lacking in pirate("demo").stdout
    result = pirate("demo", "camera")
    assert result.exit_code == 2
    assert lacking in result.stderr


@pytest.mark.thorough
def test_all_are_played_with_a_page_that_leads_to_each(
    pirate: Callable[..., Result],
    own: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    paths = [own("list robots", "{says: pirate_ii}", "one"), own("check nowhere", "{}", "two")]
    monkeypatch.setattr(library, "scenes", lambda: paths)
    result = pirate("demo", "--all", "-o", tmp_path / "out")

    assert result.exit_code == 1
    assert "one: ✓ as expected" in result.stdout
    assert "two: ✗ not as expected" in result.stdout
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert 'href="one/index.html"' in page
    assert 'href="two/index.html"' in page


@pytest.mark.thorough
def test_no_page_is_written_over_somebodys_work(
    pirate: Callable[..., Result],
    own: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = own("list robots", "{says: pirate_ii}", "one")
    monkeypatch.setattr(library, "scenes", lambda: [scene])
    for words, place in ((["--all"], "index.html"), ([scene], "one/index.html")):
        mine = tmp_path / place.replace("/", "_")
        (mine / place).parent.mkdir(parents=True)
        (mine / place).write_text("<p>mine</p>", "utf-8")

        refused = pirate("demo", *words, "-o", mine)

        assert refused.exit_code == 2
        assert "was not written by this program" in refused.stderr
        assert (mine / place).read_text("utf-8") == "<p>mine</p>"
        assert pirate("demo", *words, "-o", mine, "--overwrite").exit_code == 0


def test_a_name_that_is_not_known_is_refused(pirate: Callable[..., Result]) -> None:
    result = pirate("demo", "bent")
    assert result.exit_code == 2
    assert "did you mean 'bend'" in result.stderr
    assert pirate("demo", "bend", "--all").exit_code == 2


@pytest.mark.thorough
def test_ctrl_c_ends_the_run_in_its_safe_state_and_the_demo(tmp_path: Path) -> None:
    def hears_signals() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    code = "from pirate_sm.cli.entry import main; main()"
    process: Any = subprocess.Popen(
        [sys.executable, "-c", code, "demo", "bend", "--speed", "1", "-o", str(tmp_path)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"},
        start_new_session=True, preexec_fn=hears_signals,  # noqa: PLW1509 - no threads here
    )  # fmt: skip
    shown = ""
    for line in process.stdout:
        shown += line
        if "ClampFront sent" in line:  # as a terminal does, to the whole group
            os.killpg(process.pid, signal.SIGINT)
            break
    rest, problems = process.communicate(timeout=60)

    assert process.returncode == 130
    assert "interrupted" in shown + rest
    assert problems.endswith("interrupted\n")
    assert "Traceback" not in problems


@pytest.mark.parametrize(
    ("the_run", "code", "said"),
    [
        # While a run starts, Ctrl-C ends it at once.
        ("signal.signal(2, signal.SIG_DFL); os.kill(os.getpid(), 2)", 130, "interrupted"),
        # It may also have ended by itself just before.
        ("os.kill(os.getppid(), signal.SIGINT)", 130, "interrupted"),
        ("signal.signal(15, signal.SIG_IGN); os.kill(os.getppid(), 15)", 143, "stopped"),
    ],
)
def test_nothing_more_is_played_after_a_request_to_stop(
    pirate: Callable[..., Result],
    own: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    the_run: str,
    code: int,
    said: str,
) -> None:
    scenes = [own("list robots", "{}", name) for name in ("one", "two")]
    monkeypatch.setattr(library, "scenes", lambda: scenes)
    monkeypatch.setattr(demo, "_THIS_PROGRAM", f"import os, signal; {the_run}")

    result = pirate("demo", "--all", "-o", tmp_path / "out")

    assert result.exit_code == code
    assert result.stderr == f"{said}\n"
    assert result.stdout.count("$ pirate list robots") == 1
    assert "expected" not in result.stdout

"""Misuse gives one clear message and exit code 2; nothing has moved."""

from __future__ import annotations

import builtins
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pirate_sm.simulation
from pirate_sm import __version__

from .conftest import NEWT, ROOT

PATROL = NEWT / "patrol.yaml"
TRACE = ("--backend", "trace")


def refused(result: Any) -> str:
    """The message of a command that was refused."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    return result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--speed", "fast"), "expected max, realtime, or a factor"),
        (("--speed", "0"), "expected max, realtime, or a factor"),
        (("--speed", "-2"), "expected max, realtime, or a factor"),
        (("--speed", "nan"), "expected max, realtime, or a factor"),
        (("--guard-for", "10"), "expected a duration"),
        (("--guard-for", "0 s"), "expected a duration above zero"),
        (("--speed", "inf"), "expected max, realtime, or a factor"),
        (("--seed", "one"), "Invalid value for '--seed': expected a whole number\n"),
        (("--seed", "-1"), "Invalid value for '--seed': expected at least 0\n"),
        (("--backend", "simulator"), "there is no backend 'simulator'"),
        (("--set", "look"), "expected NAME=VALUE"),
        (("--set", "=3 s"), "expected NAME=VALUE"),
        (("--set", "look=3"), "parameter 'look'"),
        (("--set", "look=1 h"), "look"),
        (("--set", "lok=3 s"), "did you mean 'look'"),
        (("--set", "look=3 s", "--set", "look=4 s"), "twice"),
        (("--from", "outt"), "did you mean 'out'"),
        (("--state", "Grip"), "expected REGION=STATE"),
        (("--state", "Grpi=Loose"), "Grip"),
        (("--robot", "pirate_iii"), "did you mean 'pirate_ii'"),
        (("--pipe", "mitre_9"), "did you mean 'mitre_90'"),
        (("--pipe", "mitre_90"), "cannot clamp"),
        (("--defect", "hind_wheel_ded"), "did you mean 'hind_wheel_dead'"),
        (("--defect", "hind_wheel_dead", *TRACE), "--backend sim"),
        (("--fire", "look"), "--backend trace"),
        (("--fire", "loook", *TRACE), "did you mean 'look'"),
        (("--fire", "look=soon", *TRACE), "expected TRIGGER or TRIGGER=SECONDS"),
        (("--fire", "look=-1", *TRACE), "expected TRIGGER or TRIGGER=SECONDS"),
        (("--script", "nowhere.yaml", *TRACE), "nowhere.yaml"),
        (("--json", "--quiet"), "exclude each other"),
        (("--json", "--plain"), "exclude each other"),
        (("--no-such-option",), "--no-such-option"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_an_option_that_does_not_fit(
    pirate_run: Any, options: tuple[str, ...], message: str
) -> None:
    assert message in refused(pirate_run(PATROL, *options))


def test_the_nearest_of_some_fixed_words_is_suggested(pirate: Any) -> None:
    assert "there is no 'robts'; did you mean 'robots'?" in refused(pirate("list", "robts"))
    assert "there is no 'x'; expected one of text, json" in refused(
        pirate("check", "--format", "x")
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["mitre_bend"], "did you mean: pirate run mitre_bend?"),
        (["mitre_bnd"], "did you mean: pirate run mitre_bend?"),
        (["mine/bend.yaml"], "did you mean: pirate run mine/bend.yaml?"),
        (["mine/my bend.yaml"], "did you mean: pirate run 'mine/my bend.yaml'?"),
        (["mine/profile.yaml"], "did you mean: pirate check mine/profile.yaml?"),
        (["help"], "did you mean: pirate --help?"),
        (["version"], "did you mean: pirate --version?"),
        (["rum"], "Did you mean 'run'"),
        (["run", "mitre_bend", "--set", "give_up", "30s"], "did you mean: --set give_up=30s?"),
        (["run", "mitre_bend.yaml"], "no mission at 'mitre_bend.yaml'; did you mean 'mitre_bend'?"),
        (["run", "mine/mitre_bend.yaml"], "there is no mission at 'mine/mitre_bend.yaml'\n"),
        (["run", "climb", "--pipe", "straight_113.yaml"], "did you mean 'straight_113'?"),
        (["run", "a.mcap"], "'a.mcap' is a recording: use 'pirate report a.mcap'"),
        (["check", "a.mcap"], "'a.mcap' is a recording: use 'pirate report a.mcap'"),
    ],
)
def test_a_command_line_that_is_nearly_right_is_shown_right(
    pirate: Any, words: list[str], message: str
) -> None:
    assert message in refused(pirate(*words))


@pytest.mark.parametrize("word", ["/etc", "docs/missions.md", "mine/"])
def test_a_path_that_is_no_mission_is_not_to_be_run(pirate: Any, word: str) -> None:
    assert "did you mean" not in refused(pirate(word))


def test_no_mission_at_all(pirate_run: Any) -> None:
    assert "MISSION" in refused(pirate_run())


def test_a_shipped_mission_that_is_misspelt(pirate_run: Any) -> None:
    assert "did you mean 'mitre_bend'" in refused(pirate_run("mitre_bent"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "there is no mission at"),
        (b"", "empty"),
        (b"\x00\x01\x02\xff\xfe", "text"),
        (b"just words", "mapping"),
    ],
)
def test_a_file_that_is_no_mission(
    pirate_run: Any, tmp_path: Path, content: bytes | None, message: str
) -> None:
    path = tmp_path / "mission.yaml"
    if content is not None:
        path.write_bytes(content)

    text = refused(pirate_run(path))
    assert "mission.yaml" in text
    assert message in text


def test_a_directory(pirate_run: Any, tmp_path: Path) -> None:
    assert "directory" in refused(pirate_run(f"{tmp_path}/"))


def test_a_mission_with_many_faults_shows_them_all_with_their_lines(
    pirate_run: Any, tmp_path: Path
) -> None:
    mission = tmp_path / "wrong.yaml"
    text = PATROL.read_text("utf-8").replace("GoAhead", "GoAhaed").replace("30 s", "30")
    mission.write_text(text.replace("robot: ../newt", f"robot: {NEWT}"), encoding="utf-8")

    told = refused(pirate_run(mission))
    assert told.count("wrong.yaml:") >= 2


def test_a_mission_without_a_pipe_cannot_be_simulated(pirate_run: Any) -> None:
    assert "--pipe" in refused(pirate_run(NEWT / "take_hold.yaml"))


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("trigger: look", "expected a list"),
        ("- {trigger: look, afer: 1 s}", "after"),
        ("- {trigger: look, after: 3}", "after"),
        ("- {trigger: look, phase: inside}", "inside"),
    ],
)
def test_a_script_that_does_not_fit(
    pirate_run: Any, tmp_path: Path, script: str, message: str
) -> None:
    path = tmp_path / "fire.yaml"
    path.write_text(script, encoding="utf-8")

    assert message in refused(pirate_run(PATROL, *TRACE, "--script", path))


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Lets a package be missing for all that the simulator imports."""

    def without(missing: str) -> None:
        # The simulator is imported again here. Afterwards its parent must have the old module back,
        # not only the table of modules: else later tests patch one of two.
        monkeypatch.setattr(pirate_sm, "simulation", pirate_sm.simulation)
        for name in [name for name in sys.modules if name.startswith("pirate_sm.simulation")]:
            monkeypatch.delitem(sys.modules, name)
        genuine = builtins.__import__

        def without_it(name: str, *arguments: Any, **options: Any) -> Any:
            if name.partition(".")[0] == missing:
                raise ModuleNotFoundError(f"No module named '{missing}'", name=missing)
            return genuine(name, *arguments, **options)

        monkeypatch.setattr(builtins, "__import__", without_it)

    return without


def test_a_missing_extra_is_named_with_how_to_install_it(
    pirate_run: Any, without: Callable[[str], None]
) -> None:
    without("mujoco")

    told = refused(pirate_run(PATROL, "--backend", "physics"))
    assert "needs mujoco, which is not installed" in told
    assert "pip install 'pirate-sm[physics]'" in told


def test_a_simulator_that_is_not_built_and_cannot_compile_itself_says_so(
    pirate_run: Any, without: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_JIT", "1")
    without("numba")

    told = refused(pirate_run(PATROL))
    assert "the simulator cannot run here: PIRATE_SM_JIT is set" in told
    assert "pip install 'pirate-sm[jit]'" in told


def test_a_rehearsal_says_so_too(
    pirate: Any, without: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_JIT", "1")
    without("numba")

    assert "pip install 'pirate-sm[jit]'" in refused(pirate("check", "climb", "--rehearse"))


def test_a_viewer_needs_a_display_and_the_backend_that_has_one(
    pirate_run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert "the backend sim has no viewer" in refused(pirate_run(PATROL, "--view"))
    if sys.platform == "linux":
        told = refused(pirate_run(PATROL, "--backend", "physics", "--view"))
        assert "there is no display here for MuJoCo's viewer" in told
        assert "--live" in told


def test_the_physics_has_no_bend_in_a_round_pipe(pirate_run: Any, tmp_path: Path) -> None:
    bent = (ROOT / "tests/robots/newt/elbow.yaml").read_text(encoding="utf-8")
    path = tmp_path / "bent.yaml"
    path.write_text(bent + "section: round\n", encoding="utf-8")

    told = refused(pirate_run(PATROL, "--backend", "physics", "--pipe", path))
    assert "no bends in a round pipe" in told


def test_options_do_what_they_say(pirate_run: Any, tmp_path: Path) -> None:
    script = tmp_path / "fire.yaml"
    script.write_text("- {phase: look, trigger: home, after: 250 ms}\n", encoding="utf-8")
    result = pirate_run(
        PATROL, *TRACE, "--json", "--fire", "look=3", "--script", script, "--set", "look=1 min"
    )  # fmt: skip
    lines = [json.loads(text) for text in result.stdout.splitlines()]
    waits = {line["phase"]: line["t"] for line in lines if line.get("status") == "waiting"}
    fired = {line["phase"]: line["t"] for line in lines if line["type"] == "trigger"}

    assert result.exit_code == 0
    assert fired["out"] - waits["out"] == pytest.approx(3.0)
    assert fired["look"] - waits["look"] == pytest.approx(0.25)


def test_a_run_may_begin_with_a_later_phase(pirate_run: Any) -> None:
    result = pirate_run(
        PATROL, *TRACE, "--json", "--from", "home",
        "--state", "Grip=BothHeld", "--state", "Lamp=Lit",
    )  # fmt: skip
    lines = [json.loads(text) for text in result.stdout.splitlines()]

    assert [line["phase"] for line in lines if line.get("status") == "entered"] == ["home", "halt"]
    assert lines[0]["from"] == "home"
    assert result.exit_code == 0


def test_help_and_version_ask_for_nothing_heavy() -> None:
    code = (
        "import sys, pirate_sm.cli.entry; "
        "heavy = {'pydantic', 'numpy', 'numba', 'statemachine', 'yaml', 'rich', 'asyncio', 'cv2'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert told.stdout == "[]\n"


def test_help_names_every_option(pirate_run: Any, pirate: Any) -> None:
    for result in (pirate_run("--help"), pirate("run", "--help")):
        assert result.exit_code == 0
        for option in (
            "--backend", "--robot", "--pipe", "--set", "--from", "--seed", "--speed", "--defect",
            "--json", "--quiet",
        ):  # fmt: skip
            assert option in result.stdout


def test_the_version_is_reported(pirate_run: Any, pirate: Any) -> None:
    for result in (pirate_run("--version"), pirate("--version")):
        assert result.exit_code == 0
        assert result.stdout.splitlines()[0] == f"pirate-sm {__version__}"


@pytest.mark.parametrize("backend", [(), ("--backend", "trace"), ("--backend", "bay")])
def test_a_port_is_refused_where_no_real_robot_would_move(
    pirate: Callable[..., Any], backend: tuple[str, ...]
) -> None:
    result = pirate("run", "mitre_bend", *backend, "--port", "/dev/ttyACM0", "--baud", "9600")

    assert result.exit_code == 2
    assert "has no port: the real robot would not move" in result.stderr
    assert "leave out --port, --baud" in result.stderr


@pytest.mark.parametrize(
    ("backend", "words", "lacks", "leave_out"),
    [
        ("bay", ["--ruler"], "has no simulated ruler", "use --backend sim, or leave out --ruler"),
        ("sim", ["--line", "loss_in=20%"], "has no emulated line", "use --backend bay"),
        ("bay", ["--fire", "past"], "triggers can be fired in a trace only", "--backend trace"),
        ("trace", ["--twin", "t.yaml", "--defect", "a"], "simulated robot", "--defect, --twin"),
        ("serial", ["--port", "x", "--twin", "t.yaml"], "no simulated robot", "leave out --twin"),
    ],
)
def test_an_option_that_a_backend_does_not_have_is_refused(
    pirate_run: Callable[..., Any], backend: str, words: list[str], lacks: str, leave_out: str
) -> None:
    result = pirate_run("mitre_bend", "--backend", backend, "--no-record", "--yes", *words)

    assert result.exit_code == 2
    assert lacks in result.stderr
    assert leave_out in result.stderr


HIDDEN = """
import os, pathlib, sys
from pirate_sm.cli.start import main
inside = os.sep + "locked" + os.sep
def look(path):
    if not isinstance(path, int) and inside in os.path.abspath(os.fsdecode(path)):
        raise PermissionError(13, "Permission denied", path)
def refuse(event, arguments):
    if event in ("open", "os.mkdir"):
        look(arguments[0])
def asking(ask):
    def asked(path, *rest, **more):
        look(path)
        return ask(path, *rest, **more)
    return asked
sys.addaudithook(refuse)
os.stat, os.lstat = asking(os.stat), asking(os.lstat)
main()
"""
"""The command `pirate` where a folder `locked` may not be entered, whoever runs the tests."""


@pytest.mark.thorough
@pytest.mark.parametrize("place", ["./locked/it", "n" * 300])
@pytest.mark.parametrize(
    "line",
    [
        *(
            "report {}.mcap",
            "report {}",
            "graph {}.yaml",
            "export {}.mcap --csv out",
            "fit {}.mcap",
        ),
        *(
            "compare {} .",
            "compare . {}",
            "run {}.yaml",
            "run mitre_bend --pipe {}.yaml --no-check",
        ),
        *("robot {}/profile.yaml", "map {}.mcap", "graph mitre_bend -o {}.svg"),
        "campaign mitre_bend --no-check --seeds 2 --output {}",
    ],
)
def test_what_cannot_be_looked_at_is_refused_with_the_reason(
    place: str, line: str, tmp_path: Path
) -> None:
    (tmp_path / "locked").mkdir()
    result = subprocess.run(
        [sys.executable, "-c", HIDDEN, *line.format(place).split()],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )

    assert result.returncode == 2, result.stderr
    reasons = ["Permission denied"] if "locked" in place else ["File name too long", "there is no"]
    assert any(reason in result.stderr for reason in reasons), result.stderr
    assert "an internal error" not in result.stderr


def test_what_cannot_be_looked_at_is_checked_as_unreadable(tmp_path: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-c", HIDDEN, "check", "./locked/it.yaml"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )

    assert "cannot be read: Permission denied" in result.stdout
    assert "there is no" not in result.stdout + result.stderr

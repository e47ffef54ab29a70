"""What a shell is answered: which values fit, and in which form."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.core import TyperOption

from pirate_sm.checking import catalogue
from pirate_sm.cli import entry
from pirate_sm.cli.completion import ASKING
from pirate_sm.cli.completion.answer import answered
from pirate_sm.core import library
from pirate_sm.core._model.robot.simulation import LineFaults
from pirate_sm.lab.campaign.campaign_model import StartJitter
from pirate_sm.robot import part_names as backends
from pirate_sm.running.wiring import BACKENDS

from ..conftest import NEWT, ROOT

PIRATE, PIRATE_RUN = (typer.main.get_command(each) for each in (entry.commands, entry.only_run()))
BREAKS = " \t\n\"'><=;|&(:"
MISSION = "mission: mine\nrobot: pirate_ii\nstart: a\ndescription: of my own\nphases: {a: {}}\n"


def answer(line: str, shell: str = "zsh", command: Any = PIRATE) -> str:
    asked = {
        "PIRATE_SM_COMPLETE": shell,
        "PIRATE_SM_LINE": line,
        "PIRATE_SM_BREAKS": BREAKS,
    }
    return answered(command, asked, entry.about)


def values(line: str, command: Any = PIRATE) -> list[str]:
    """The values that fit at the end of a line."""
    return [each.partition("\t")[0] for each in answer(line, command=command).splitlines()]


def about(line: str, value: str) -> str:
    """What is said about a value."""
    return dict(each.split("\t", 1) for each in answer(line).splitlines())[value]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.delenv("PIRATE_SM_RUNS", raising=False)
    return tmp_path


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("pirate ru", ["run"]),
        ("pirate ne", ["new"]),
        ("pirate new pi", ["pipe"]),
        ("pirate run --see", ["--seed"]),
        ("pirate run mitre_bend_o", ["mitre_bend_other_side"]),
        ("pirate run mitre_bend --from pr", ["prepare"]),
        ("pirate run mitre_bend --from=pr", ["--from=prepare"]),
        ("pirate run --from pr", []),
        ("pirate run mitre_bend --set ", ["give_up="]),
        ("pirate run mitre_bend --set give_up=", ["give_up=60 s"]),
        ("pirate run mitre_bend --set 'give_up=2 s' --set ", []),
        ("pirate run mitre_bend --state Li", ["LightingState="]),
        ("pirate run mitre_bend --state LightingState=", ["LightingState=Off", "LightingState=On"]),
        ("pirate run mitre_bend --defect wheels", ["wheels_3_4_dead"]),
        ("pirate run mitre_bend --defect wheels_3_4_dead --defect wheels", []),
        ("pirate run --defect wheel_1_dead:", ["wheel_1_dead:friction=", "wheel_1_dead:after="]),
        ("pirate run --defect wheel_1_dead:friction=1Nm,a", ["wheel_1_dead:friction=1Nm,after="]),
        ("pirate run --robot pirate_ii_imu --defect wheels", ["wheels_3_4_dead"]),
        ("pirate run --backend s", ["serial", "sim"]),
        ("pirate run --detector vis", ["vision:"]),
        ("pirate run --detector vision:setup_", [f"vision:setup_{each}" for each in (1, 2, 3)]),
        ("pirate run --pipe mitre_90_ti", ["mitre_90_tilted"]),
        ("pirate run --fidelity f", ["fast"]),
        ("pirate run --seed ", []),
        ("pirate run mitre_bend ", []),
        ("pirate run -- mitre_bend_o", ["mitre_bend_other_side"]),
        ("pirate run mitre_bend --fire p", ["prepare", "pass"]),
        ("pirate run exp_2b_detector --fire prep", ["prepare"]),  # of the mission that it calls
        ("pirate run mitre_bend --fire wi", ["within"]),
        (f"pirate campaign {ROOT}/campaigns/bend_physics.yaml --cell 45", ["45 deg"]),
        ("pirate console --theme li", ["light"]),
        ("pirate demo be", ["bend"]),
        ("pirate list mi", ["missions"]),
        ("pirate config p", ["path"]),
        ("pirate completion ", ["bash", "zsh", "fish"]),
        ("pirate new mission x --pipe house --route ", ["to_house", "along_main"]),
        ("pirate plan pirate_ii --to LightingState=O", ["LightingState=Off", "LightingState=On"]),
        ("pirate plan pirate_ii --to LightingState=On,Rot", ["LightingState=On,RotationState="]),
        ("pirate plan pirate_ii --to-phase mitre_bend:pr", ["mitre_bend:prepare"]),
        ("pirate graph mitre_bend --highlight enter,pr", ["enter,prepare"]),
        ("pirate graph mitre_bend --highlight enter,ent", []),
        ("pirate calibrate --skip gamma_1 --skip gamma", ["gamma_2", "gamma_3", "gamma_4"]),
        ("pirate experiment 2", ["2", "2a", "2b", "2c"]),
        ("pirate explain step.imp", ["step.impossible"]),
        ("pirate explain sensor.si", ["sensor.silent"]),
        ("pirate camera look synthetic_h", ["synthetic_hard"]),
        ("pirate panel nano", ["nanokontrol2"]),
        ("pirate no_such_command ", []),
        ("pirate run no_such_mission --from ", []),
        ("pirate run --robot no_such_robot --defect ", []),
        ("pirate run --no-such-option=", []),
        ("pirate run 'mitre_bend_o", ["mitre_bend_other_side"]),
        ("", ["run"]),
    ],
)  # fmt: skip
def test_what_fits(here: Path, line: str, expected: list[str]) -> None:
    found = values(line)

    assert found[: len(expected)] == expected if line == "" else found == expected


def test_pirate_run_has_no_name_of_a_command(here: Path) -> None:
    assert values("pirate-run mitre_bend --from pr", PIRATE_RUN) == ["prepare"]


def test_every_name_has_its_line(here: Path) -> None:
    assert about("pirate ", "run") == "Run a mission."
    assert about("pirate ", "new") == entry.GROUPS["new"]
    assert about("pirate run ", "mitre_bend").startswith("From the first leg")
    assert about("pirate run --robot ", "pirate_ii").startswith("PIRATE")
    assert about("pirate run mitre_bend --from ", "pass").startswith("Hold with the front")
    assert about("pirate run --backend ", "sim") == "the kinematic simulator"
    assert about("pirate run mitre_bend --set ", "give_up=").endswith("(60 s)")
    assert about("pirate run --s", "--seed") == "Seed of all random numbers."


def test_all_of_a_kind_are_there(here: Path) -> None:
    assert values("pirate run ") == [path.stem for path in library.missions()]
    assert values("pirate run --robot ") == [path.name for path in library.robots()]
    assert values("pirate run --backend ") == BACKENDS.names == sorted(backends.BACKENDS)
    assert set(values("pirate explain ")) > set(catalogue.entries())
    assert values("pirate run --jitter ") == [f"{name}=" for name in StartJitter.model_fields]
    assert values("pirate run --line ") == [f"{name}=" for name in LineFaults.model_fields]


def test_files_are_offered_where_they_fit(here: Path) -> None:
    (here / "m.yaml").write_text(MISSION)
    (here / "m.pipe.yaml").write_text("pipe: p\ndiameter: 120 mm\nsegments: []\n")
    (here / "m.mcap").write_bytes(b"")
    (here / "m.txt").write_text("")
    (here / "m").mkdir()
    (here / "m" / "profile.yaml").write_text("robot: m\nchart: chart.yaml\ndescription: small\n")
    (here / ".m").mkdir()

    def files(line: str) -> list[str]:
        return [each for each in values(line) if each not in {"mitre_bend"} and "mitre" not in each]

    assert files("pirate run m") == ["m/", "m.yaml"]
    assert files("pirate console m") == ["m/", "m.mcap", "m.yaml"]
    assert files("pirate run --pipe m") == ["m/", "m.pipe.yaml"]
    assert files("pirate run --robot m") == ["m"]
    assert files("pirate report m") == ["m/", "m.mcap"]
    assert files("pirate campaign m") == ["m/", "m.yaml"]
    assert files("pirate check m") == ["m/", "m.pipe.yaml", "m.yaml"]
    assert files("pirate report x.mcap -o m") == ["m/", "m.mcap", "m.pipe.yaml", "m.txt", "m.yaml"]
    assert about("pirate run m", "m.yaml") == "of my own"
    assert about("pirate run --robot m", "m") == "small"


def test_a_path_stays_as_it_is_typed(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(here))
    (here / "one").mkdir()
    (here / "one" / "m.yaml").write_text(MISSION)

    assert values("pirate run one/") == ["one/m.yaml"]
    assert values("pirate run ./one/") == ["./one/m.yaml"]
    assert values("pirate run ~/one/") == ["~/one/m.yaml"]
    assert values(f"pirate run {here}/on") == [f"{here}/one/"]
    assert values("pirate run nowhere/") == []


def test_a_robot_beside_its_mission_is_found(here: Path) -> None:
    mission = NEWT / "patrol.yaml"

    assert values(f"pirate run {mission} --state G") == ["Grip="]
    assert values(f"pirate run {mission} --from ho") == ["home", "hold_on"]


def test_recordings_are_offered_newest_first(here: Path) -> None:
    (here / "runs").mkdir()
    for name in ("2026-01-02_a.mcap", "2026-01-03_b.mcap", "note.txt"):
        (here / "runs" / name).write_bytes(b"")

    assert values("pirate replay ") == ["runs/", "runs/2026-01-03_b.mcap", "runs/2026-01-02_a.mcap"]


def test_phases_of_a_recording(here: Path, pirate_run: Callable[..., Any]) -> None:
    run = here / "run.mcap"
    pirate_run("enter_2d", "--quiet", "--speed", "max", "--record", run)
    cut = here / "cut.mcap"
    cut.write_bytes(run.read_bytes()[:-1000])

    for each in (run, cut):
        assert values(f"pirate run --resume {each} --at reg") == ["regrip"]


def test_signals_of_a_recording_or_a_table(here: Path, pirate_run: Callable[..., Any]) -> None:
    run = here / "run.mcap"
    pirate_run("enter_2d", "--backend", "trace", "--quiet", "--record", run)
    (here / "table.csv").write_text("time_s,slip_1,slip_2,wheel_torque_1_Nm\n0,0,0,0\n")

    assert values("pirate fit run.mcap --slip sl") == ["slip_speed_{}", "slip_{}"]
    assert values("pirate fit run.mcap --torque wheel") == ["wheel_current_{}", "wheel_torque_{}"]
    assert values("pirate fit table.csv --slip ") == ["time_s", "slip_{}", "wheel_torque_{}_Nm"]
    assert values("pirate fit no.csv --slip ") == []
    os.mkfifo(here / "fifo.csv")
    os.mkfifo(here / "fifo.mcap")
    assert values("pirate fit fifo.csv --slip ") == values("pirate fit fifo.mcap --slip ") == []


@pytest.mark.parametrize(
    "content",
    [
        b"mission: m\nphases: {a: [}\n",
        b"phases: " + b"[" * 50_000,
        b"phases: {a: {}, a: {}}\nmission: m\n",
        b"a: &a [x]\nb: &b [*a, *a]\nphases: *b\nmission: m\n",
        b"\xff\xfe\x00",
        b"phases: {\x07: {}}\n",
        b"phases: 3\nmission: 4\nrobot: [5]\nparameters: {a: 6}\n",
        b"",
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_read_offers_nothing_and_says_nothing(
    here: Path, content: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    (here / "bad.yaml").write_bytes(content)
    os.mkfifo(here / "fifo.yaml")
    (here / "gone.yaml").symlink_to("nowhere")
    (here / "bad.mcap").write_bytes(content)

    for of in ("bad.yaml", "fifo.yaml", "gone.yaml"):
        for option in ("--from", "--set", "--state no=", "--state"):
            answer(f"pirate run {of} {option} ")
        assert answer(f"pirate run {of} --from ") == ""
        answer(f"pirate graph {of} --highlight ")
        answer(f"pirate new mission x --pipe {of} --route ")
    answer("pirate run b")
    answer("pirate demo b")
    assert answer("pirate run --resume bad.mcap --at ") == ""
    assert capfd.readouterr() == ("", "")


def test_faulty_settings_say_nothing(here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (here / "pirate.toml").write_text("backend = [\n")

    assert answer("pirate replay ") == ""
    assert capfd.readouterr() == ("", "")


def test_signs_that_a_terminal_obeys_are_kept_from_it(here: Path) -> None:
    (here / "a\x1b[31m.yaml").write_text(MISSION)
    (here / "zz\tin.yaml").write_text(MISSION)
    (here / "m.yaml").write_text(MISSION.replace("of my own", '"\\e[31m red\\nline"'))

    assert values("pirate run a") == []
    assert values("pirate run zz") == []
    assert about("pirate run m.", "m.yaml") == "\\x1b[31m red\\nline"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("pirate run mitre_bend_o", ["mitre_bend_other_side "]),
        ("pirate run --robot=pirate_ii_", ["pirate_ii_imu "]),
        ("pirate run --detector vision:setup_1", ["setup_1 "]),
        ("pirate run mitre_bend --set g", ["give_up="]),
        ("pirate run mitre_bend --set give_up=", ["60\\ s "]),
        ("pirate run mitre_bend --set 'give_up=", ["60 s"]),
        ("pirate run odd", ["odd\\$\\(x\\)\\;\\'.yaml "]),
        ("pirate run 'odd", []),
        ("pirate run below", ["below/"]),
        ("pirate replay below/x:y", ["y.mcap "]),
    ],
)  # fmt: skip
def test_bash_gets_what_it_is_to_insert(here: Path, line: str, expected: list[str]) -> None:
    (here / "odd$(x);'.yaml").write_text(MISSION)
    (here / "below").mkdir()
    (here / "below" / "x:y.mcap").write_bytes(b"")

    assert answer(line, "bash").splitlines() == expected


def test_names_of_other_packages_are_offered_without_importing_them(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    point = EntryPoint("other", "no_such_package_at_all:PART", "pirate_sm.backends")
    monkeypatch.setattr("pirate_sm.core.registry.entry_points", lambda group: [point])

    assert "other" in values("pirate run --backend ")
    assert "other" in values("pirate run --detector ")


def test_an_answer_needs_neither_models_nor_numbers() -> None:
    code = (
        "import atexit, sys; sys.argv = ['pirate']\nfrom pirate_sm.cli.start import main\n"
        "atexit.register(lambda: print(*sys.modules, file=sys.stderr))\nmain()"
    )
    for line in ("run ", "run mitre_bend --from ", "run mitre_bend --defect ", "run --backend "):
        ran = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, check=True, text=True, cwd=ROOT,
            env={
                **os.environ, "PYTHONPATH": str(ROOT),
                "PIRATE_SM_COMPLETE": "fish", "PIRATE_SM_LINE": f"pirate {line}",
            },
        )  # fmt: skip
        assert ran.stdout.count("\n") > 1
        modules = set(ran.stderr.split())
        assert "typer" in modules
        assert not {"pydantic", "numpy", "rich", "serial", "mujoco"} & modules


def test_a_command_line_runs_even_if_the_variable_is_set(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ASKING, "bash")
    monkeypatch.setattr(sys, "argv", ["pirate", "config", "path"])
    monkeypatch.setattr(sys, "stdout", printed := io.TextIOWrapper(io.BytesIO(), "utf-8"))

    with pytest.raises(SystemExit) as end:
        entry.main()

    assert end.value.code == 0
    printed.seek(0)
    assert printed.read().endswith("config.toml\n")


def test_every_option_that_takes_a_name_or_a_file_completes_it() -> None:
    free = {
        "boards", "seconds", "noise", "cells", "scheduler", "fire", "start_at", "images",
        "guard_for", "limit", "square", "board", "radius", "threshold", "until",
    }  # fmt: skip
    texts = {"NAME", "FILE", "DIR", "FOLDER", "PATH", "MISSION", "PHASE", "SIGNAL", "ROBOT", "OUT"}
    left = [
        f"{name} {each.name}"
        for name in entry.COMMANDS
        for each in typer.main.get_command(entry._single(name)).params
        if isinstance(each, TyperOption)
        and each.name not in free
        and (each.metavar or "").partition(".")[0] in texts
        and each._custom_shell_complete is None
    ]
    assert left == []


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_program_is_completed_in_every_shell(shell: str, pirate: Callable[..., Any]) -> None:
    programs = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["scripts"]

    script = pirate("completion", shell)

    assert script.exit_code == 0
    assert all(f" {name}" in script.output for name in programs)
    assert "eval" not in script.output

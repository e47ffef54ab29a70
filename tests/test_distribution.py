"""What pyproject.toml says of the package, beside what the package is."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from representative import thorough_but
from typer.testing import CliRunner

from pirate_sm import __version__
from pirate_sm.cli.entry import commands
from pirate_sm.cli.output.event_lines import FORMAT as LINES
from pirate_sm.core.events import ALPHABET_VERSION
from pirate_sm.running.recording.format.header import FORMAT as RECORDING

ROOT = Path(__file__).resolve().parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
OF_DEVELOPERS = {"bench", "browser", "dev", "docs", "mutants"}
PIRATE = "from pirate_sm.cli.entry import main; main()"

NEEDING = {
    ("campaign", "pyarrow"): (PIRATE, "campaign", "{campaign}", "-o", "{here}"),
    ("campaign", "distributed"): (PIRATE, "campaign", "{campaign}", "-o", "{here}"),
    ("falsify", "cmaes"): (PIRATE, "margins", "mitre_bend", "--falsify", "-o", "{here}/f"),
    ("fit", "scipy"): (PIRATE, "fit", "{run}"),
    ("gym", "gymnasium"): ("import pirate_sm.learning",),
    ("jit", "numba"): (PIRATE, "run", "mitre_bend", "--no-record"),
    ("live", "foxglove"): (PIRATE, "run", "mitre_bend", "--backend", "trace", "--live"),
    ("lsp", "pygls"): (PIRATE, "lsp"),
    ("page", "tornado"): (PIRATE, "page", "{run}"),
    ("parquet", "pyarrow"): (PIRATE, "export", "{run}", "--parquet", "{here}/tables"),
    ("physics", "mujoco"): (PIRATE, "run", "mitre_bend", "--backend", "physics"),
    ("ros2", "rosbags"): (PIRATE, "export", "{run}", "--ros2", "{here}/bag"),
    ("sensitivity", "SALib"): (PIRATE, "campaign", "campaigns/sensitivity.yaml", "-o", "{here}/s"),
    ("serial", "serial"): (PIRATE, "doctor", "--port", "{here}/no_port"),
    ("serial", "rosbags"): (PIRATE, "run", "mitre_bend", "--backend", "bay"),
    ("vision", "cv2"): (PIRATE, "camera", "look", "synthetic"),
}
"""Something that needs a package of an extra: a line of Python and its arguments."""


def test_all_is_every_extra_of_a_user() -> None:
    (whole,) = EXTRAS["all"]
    chosen = whole.removeprefix("pirate-sm[").removesuffix("]").split(",")

    assert chosen == sorted({*EXTRAS} - OF_DEVELOPERS - {"all"})
    assert {extra for extra, _ in NEEDING} == {*chosen}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a short run."""
    path = tmp_path_factory.mktemp("runs") / "run.mcap"
    result = CliRunner().invoke(
        commands, ["run", "prepare_bend", "--backend", "trace", "--record", str(path)]
    )
    assert path.exists(), result.output
    return path


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of one short mission, which is checked before the first run."""
    path = tmp_path_factory.mktemp("campaigns") / "one.yaml"
    path.write_text(
        "{format: 1, campaign: one, seeds: 0..0, missions: [{mission: prepare_bend}]}\n", "utf-8"
    )
    return path


@pytest.mark.parametrize(
    ("extra", "package"),
    thorough_but([("gym", "gymnasium")], NEEDING),
)
def test_what_needs_a_missing_extra_names_what_installs_it(
    extra: str, package: str, tmp_path: Path, recording: Path, campaign: Path
) -> None:
    code, *arguments = (
        each.format(here=tmp_path, run=recording, campaign=campaign)
        for each in NEEDING[extra, package]
    )
    hidden = f"import sys; sys.modules[{package!r}] = None; "
    # Where the simulator was built with the package, only a wish for compiling needs numba.
    wish = {"PIRATE_SM_JIT": "1"} if extra == "jit" else {}
    done = subprocess.run(
        [sys.executable, "-c", hidden + code, *arguments], env=os.environ | wish,
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip

    assert f"pip install 'pirate-sm[{extra}]'" in done.stderr
    if arguments:
        assert done.returncode == 2
        assert "Traceback" not in done.stderr


@pytest.mark.thorough
def test_a_recording_is_viewed_in_the_console_without_the_link_to_a_robot() -> None:
    hidden = "import sys; sys.modules['rosbags'] = sys.modules['serial'] = None; "
    code = hidden + "import pirate_sm.views.console.recording_viewer"

    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT).returncode == 0


def test_texts_name_extras_that_exist() -> None:
    texts = [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "pirate_sm").rglob("*.py"),
    ]
    named = {
        name
        for text in texts
        for listed in re.findall(r"pirate-sm\[([a-z,]+)\]", text.read_text("utf-8"))
        for name in listed.split(",")
    }

    assert "serial" in named
    assert named <= {*EXTRAS}


def test_everything_vendored_has_its_licence_beside_it() -> None:
    folders = {
        file.parent
        for file in (ROOT / "pirate_sm").rglob("*")
        if re.search(r"\.min\.(js|css)$|^uPlot|^three", file.name) and file.is_file()
    }
    licensed = {
        path.parent for pattern in PROJECT["license-files"] for path in ROOT.glob(pattern)
    } - {ROOT}

    assert {folder.name for folder in folders} == {"three-0.170.0", "uplot-1.6.32"}
    assert folders == licensed
    for folder in folders:
        text = (folder / "LICENSE").read_text("utf-8")
        assert "Permission is hereby granted, free of charge" in text
        assert "Copyright" in text


def test_the_workflow_runs_what_the_makefile_has() -> None:
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    makefile = (ROOT / "Makefile").read_text("utf-8")
    runs = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]

    assert runs
    for command in runs:
        program, target, *_ = command.split()
        assert program == "make"
        assert re.search(rf"^{re.escape(target)}:", makefile, re.M), target
    assert "://" not in text
    assert jobs["test"]["strategy"]["matrix"]["python"][0] == PROJECT["requires-python"][2:]


def test_the_workflow_may_fail_only_on_pythons_that_no_classifier_names() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8"))
    jobs = workflow["jobs"]
    tested = jobs["test"]["strategy"]["matrix"]["python"]
    named = [each.rpartition(" ")[2] for each in PROJECT["classifiers"] if ":: 3." in each]

    assert named
    assert {*named} <= {*tested}
    for name in ("test", "installed"):
        may_fail = re.findall(r"'(3\.\d+)'", jobs[name]["continue-on-error"])
        assert {*may_fail} == {*tested} - {*named}


def test_only_the_job_with_the_newest_of_everything_uses_no_lock() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8"))
    unlocked = {
        (name, "LOCK=" in step["run"].split())
        for name, job in workflow["jobs"].items()
        for step in job["steps"]
        if "run" in step
    }

    assert unlocked == {
        ("test", False), ("newest", True), ("wheel", False), ("installed", False)
    }  # fmt: skip
    assert "schedule" in workflow[True]  # YAML 1.1 reads the key `on` so
    assert "LOCK" not in (ROOT / ".ci" / "run").read_text("utf-8")


def test_every_wheel_of_the_workflow_is_installed_on_every_python() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8"))
    test, wheel, installed = (
        workflow["jobs"][name]["strategy"]["matrix"] for name in ("test", "wheel", "installed")
    )

    assert installed == {**wheel, **test}


def test_the_version_comes_with_those_of_the_formats() -> None:
    told = CliRunner().invoke(commands, ["--version"]).stdout

    assert told.splitlines() == [
        f"pirate-sm {__version__}",
        f"formats: files 1, JSON {LINES}, recordings {RECORDING}, events {ALPHABET_VERSION}",
    ]


def test_the_changes_have_a_heading_for_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")

    assert re.search(rf"^## {re.escape(__version__)}\b", text, re.M)

"""Another package adds a backend and a detector without a change of this one."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import pirate_sm
from pirate_sm.core.companion import Companion
from pirate_sm.core.events import DetectorWord, FaultReport, SensorFrame, SubmitResult
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.detectors.registry import DETECTORS, Asked, Detecting, Places
from pirate_sm.running.wiring import BACKENDS, Order
from pirate_sm.running.wiring.prepared import Equipment
from pirate_sm.testing import BackendContract, Candidate, DetectorContract, Subject

from .candidates import NEWT, TAKE_HOLD, candidate
from .installed import EXAMPLE, install, install_metadata

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text("utf-8")
RAISES = """
from pirate_sm.core.registry import Plugin
def make(*arguments):
    raise KeyError("rig")
PART = Plugin("raises", make)
"""
BLINKS = """
from pirate_sm.robot.detectors.registry import Detecting
from pirate_sm.core.registry import Plugin
class Blinks:
    due_s = 0.0
    listening = False
    def react(self, effects, now_s):
        pass
    def look(self, state, now_s):
        return state.eyes
    def speak(self, now_s):
        return ()
PART = Plugin("raises as it looks", lambda asked: Detecting("blinking", (Blinks(),)))
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the example is installed, and packages with faults."""
    target = tmp_path_factory.mktemp("site")
    install(EXAMPLE, target)
    (target / "breaks.py").write_text("raise RuntimeError('no licence found')\n")
    (target / "odd.py").write_text("THING = 3\n")
    (target / "raises.py").write_text(RAISES)
    (target / "blinks.py").write_text(BLINKS)
    points = {"broken": "breaks:BACKEND", "odd": "odd:THING", "gone": "nowhere:X", "sim": "odd:X"}
    points["raising"] = "raises:PART"
    detectors = {"raising": "raises:PART", "blinking": "blinks:PART"}
    groups = {"pirate_sm.backends": points, "pirate_sm.detectors": detectors}
    install_metadata(target, "pirate-faulty", groups)
    return target


@pytest.fixture(scope="module")
def example(site: Path) -> Iterator[Path]:
    """The same, while this process can import from it and our registries know it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(site))
        for registry in (BACKENDS, DETECTORS):
            registry.forget()
        yield site
    for registry in (BACKENDS, DETECTORS):
        registry.forget()


def pirate(site: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    code = "from pirate_sm.cli.start import main; main()"
    path = os.pathsep.join([str(ROOT), str(site)])
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
        check=False,
    )


class TestSlowLine(BackendContract):
    @pytest.fixture
    def candidate(self, example: Path) -> Candidate:
        make, order = BACKENDS.find("slow_line"), Order(str(NEWT / "take_hold.yaml"))
        return candidate(lambda seed: make(order, TAKE_HOLD, print).backend)


class TestClock(DetectorContract):
    @pytest.fixture
    def subject(self, example: Path) -> Subject:
        mission = load_mission(NEWT / "patrol.yaml")
        return Subject(DETECTORS.find("clock"), mission, argument="2.5")


def test_a_mission_runs_on_a_backend_of_another_package(site: Path) -> None:
    result = pirate(site, "run", str(NEWT / "patrol.yaml"), "--backend", "slow_line", "--quiet")

    assert (result.returncode, result.stderr) == (0, "")
    assert "Back where it began" in result.stdout


@pytest.mark.thorough
def test_a_mission_hears_a_detector_of_another_package(site: Path) -> None:
    mission, options = str(NEWT / "patrol.yaml"), ("--detector", "clock:12", "--plain")
    result = pirate(site, "run", mission, *options)

    assert result.returncode == 0, result.stderr
    assert "a word every 12 s" in result.stdout + result.stderr


def test_what_a_package_adds_is_listed_and_what_is_wrong_with_another_is_reported(
    site: Path,
) -> None:
    result = pirate(site, "list", "backends")

    lines = {line.split()[0]: line for line in result.stdout.splitlines() if line.startswith("  ")}
    assert result.returncode == 0
    assert "pirate-example" in lines["slow_line"]
    assert "answered late" in lines["slow_line"]
    assert "pirate-faulty" in lines["broken"]
    assert "RuntimeError: no licence found" in lines["broken"]
    assert "No module named 'nowhere'" in lines["gone"]
    assert "is of type int, expected" in lines["odd"]
    assert {"sim", "serial", "trace"} <= lines.keys()
    assert "the name is taken" in result.stdout


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("option", "name", "code", "why"),
    [
        ("--backend", "broken", 2, "breaks:BACKEND fails with RuntimeError: no licence found"),
        ("--backend", "gone", 2, "nowhere:X fails with ModuleNotFoundError: No module named"),
        (
            "--backend",
            "odd",
            2,
            "odd:THING is of type int, expected a pirate_sm.plugins.Plugin",
        ),
        ("--backend", "raising", 3, "raises:PART fails with KeyError: 'rig'"),
        ("--detector", "raising", 3, "raises:PART fails with KeyError: 'rig'"),
    ],
)
def test_a_faulty_package_is_named_with_its_entry_point_and_nothing_moves(
    site: Path, option: str, name: str, code: int, why: str
) -> None:
    result = pirate(site, "run", "mitre_bend", option, name)

    part = option.removeprefix("--")
    whose = f"the {part} '{name}' cannot be used: package pirate-faulty: "
    assert (result.returncode, result.stdout) == (code, "")
    assert result.stderr.startswith(f"{whose}{why}")
    assert "Traceback" not in result.stderr


@pytest.mark.thorough
def test_a_detector_that_fails_in_a_run_is_named_with_its_entry_point(site: Path) -> None:
    options = ("--detector", "blinking", "--quiet", "--no-record")
    result = pirate(site, "run", "mitre_bend", *options)

    whose = "the detector 'blinking' (package pirate-faulty: blinks:PART)"
    assert result.returncode == 3
    assert f"{whose} fails in look with AttributeError: 'EngineState'" in result.stdout
    assert "an internal error" not in result.stdout + result.stderr


def test_the_api_names_a_faulty_package_in_the_same_words(example: Path) -> None:
    with pytest.raises(pirate_sm.UsageError, match="pirate-faulty: odd:THING is of type int"):
        pirate_sm.run("mitre_bend", "odd")
    for options in ({"backend": "raising"}, {"detector": "raising"}):
        with pytest.raises(pirate_sm.BackendError, match="raises:PART fails with KeyError"):
            pirate_sm.run("mitre_bend", **options)  # type: ignore[arg-type]
    whose = r"^the detector 'blinking' \(package pirate-faulty: blinks:PART\) fails in look"
    assert re.match(whose, pirate_sm.run("mitre_bend", detector="blinking").message)
    with (
        pytest.raises(pirate_sm.BackendError, match=whose),
        pirate_sm.session("mitre_bend", detector="blinking") as session,
    ):
        session.advance(1.0)


@pytest.mark.thorough
def test_a_backend_that_is_misspelt_is_suggested(site: Path) -> None:
    result = pirate(site, "run", "mitre_bend", "--backend", "slow_lime")

    assert result.returncode == 2
    assert "did you mean 'slow_line'" in result.stderr


@pytest.mark.thorough
def test_an_option_that_a_detector_refuses_is_reported(site: Path) -> None:
    result = pirate(site, "run", "mitre_bend", "--detector", "clock:soon")

    assert (result.returncode, result.stderr.strip()) == (2, "expected clock:SECONDS")


@pytest.mark.thorough
def test_the_tests_in_the_documentation_pass_as_they_are_written(
    site: Path, tmp_path: Path
) -> None:
    block = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert block is not None
    (tmp_path / "test_contract.py").write_text(block[1], "utf-8")

    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(site)])},
        check=False,
    )

    assert result.returncode == 0, result.stdout
    assert int(result.stdout.split(" passed")[0].split()[-1]) > 25


@pytest.mark.parametrize(
    "kind",
    [
        *(Backend, Equipment, SubmitResult, SensorFrame, FaultReport, Candidate),
        *(Companion, Asked, Detecting, Places, DetectorWord, Subject),
    ],
)
def test_the_documentation_explains_every_member_of_the_types_that_it_names(kind: type) -> None:
    members = {*dir(kind), *inspect.get_annotations(kind)} - {*dir(tuple)}
    code = " ".join(re.findall(r"`([^`\n]+)`", PAGE))

    assert re.search(rf"\b{kind.__name__}\b", code)
    assert [m for m in members if m[0] != "_" and not re.search(rf"\b{m}\b", code)] == []

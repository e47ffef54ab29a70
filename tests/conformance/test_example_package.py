"""Another package adds a backend and a detector without a change of this one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.detectors.registry import DETECTORS
from pirate_sm.errors import BackendError
from pirate_sm.loading.mission import load_mission
from pirate_sm.registry import Plugin
from pirate_sm.testing import BackendContract, Candidate, DetectorContract, Subject
from pirate_sm.wiring import BACKENDS, Order, prepare

from .candidates import NEWT, TAKE_HOLD, candidate
from .installed import EXAMPLE, install, install_metadata

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the example is installed, and packages with faults."""
    target = tmp_path_factory.mktemp("site")
    install(EXAMPLE, target)
    (target / "breaks.py").write_text("raise RuntimeError('no licence found')\n")
    (target / "odd.py").write_text("THING = 3\n")
    points = {"broken": "breaks:BACKEND", "odd": "odd:THING", "gone": "nowhere:X", "sim": "odd:X"}
    install_metadata(target, "pirate-faulty", {"pirate_sm.backends": points})
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


def test_a_mission_hears_a_detector_of_another_package(site: Path) -> None:
    mission, options = str(NEWT / "patrol.yaml"), ("--detector", "clock:12", "--plain")
    result = pirate(site, "run", mission, *options)

    assert result.returncode == 0, result.stderr
    assert "a word every 12 s" in result.stdout + result.stderr


def test_what_a_package_adds_is_listed_and_what_is_wrong_with_another_is_told(site: Path) -> None:
    result = pirate(site, "list", "backends")

    lines = {line.split()[0]: line for line in result.stdout.splitlines() if line.startswith("  ")}
    assert result.returncode == 0
    assert "pirate-example" in lines["slow_line"]
    assert "answered late" in lines["slow_line"]
    assert "pirate-faulty" in lines["broken"]
    assert "RuntimeError: no licence found" in lines["broken"]
    assert "No module named 'nowhere'" in lines["gone"]
    assert "is a int, expected" in lines["odd"]
    assert {"sim", "serial", "trace"} <= lines.keys()
    assert "the name is taken" in result.stdout


@pytest.mark.parametrize(
    ("backend", "why"),
    [
        ("broken", "pirate-faulty: breaks:BACKEND fails with RuntimeError: no licence found"),
        ("slow_lime", "did you mean 'slow_line'"),
    ],
)
def test_a_backend_that_cannot_be_had_moves_nothing(site: Path, backend: str, why: str) -> None:
    result = pirate(site, "run", "mitre_bend", "--backend", backend)

    assert result.returncode == 2
    assert why in result.stderr
    assert "Traceback" not in result.stderr


def test_an_option_that_a_detector_refuses_is_told(site: Path) -> None:
    result = pirate(site, "run", "mitre_bend", "--detector", "clock:soon")

    assert (result.returncode, result.stderr.strip()) == (2, "expected clock:SECONDS")


def test_a_factory_of_another_package_that_breaks_is_named(
    example: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(order: object, loaded: object, say: object) -> None:
        raise KeyError("rig")

    monkeypatch.setattr("pirate_example.slow_line.BACKEND", Plugin("breaks", broken))

    with pytest.raises(BackendError, match="'slow_line' of package pirate-example fails: KeyError"):
        prepare(Order(str(NEWT / "patrol.yaml"), "slow_line"))

"""Every detector of this package keeps the contract that other packages' detectors are held to."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core import library
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.detectors.registry import DETECTORS
from pirate_sm.testing import DetectorContract, Subject

from .candidates import NEWT

# What nobody says is heard in no test: a person at the keyboard, a program outside.
SILENT = ("operator", "socket")


CAMERA = Path(__file__).resolve().parents[1] / "cameras" / "small.yaml"


class TestDetectors(DetectorContract):
    @pytest.fixture(params=["sim", "odometry", *SILENT])
    def subject(self, request: pytest.FixtureRequest, tmp_path: Path) -> Subject:
        name = request.param
        argument = str(tmp_path / "words") if name == "socket" else None
        mission = load_mission(NEWT / "patrol.yaml")
        return Subject(DETECTORS.find(name), mission, argument=argument, words=name not in SILENT)


class TestCamera(DetectorContract):
    @pytest.fixture
    def subject(self) -> Subject:
        mission = load_mission(library.find_mission("mitre_bend"))
        return Subject(DETECTORS.find("vision"), mission, argument=str(CAMERA))

    test_it_can_begin_again_for_another_mission = pytest.mark.thorough(
        DetectorContract.test_it_can_begin_again_for_another_mission
    )

"""Every detector of this package keeps the contract that other packages' detectors are held to."""

from __future__ import annotations

from pathlib import Path

import pytest

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


TO_THE_BEND = """\
format: 1
mission: to_the_bend
robot: pirate_ii
pipe: mitre_90
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: drive
phases:
  drive:
    do: [DriveForward]
    wait: [{when: detector == close, go: halt}]
    within: {time: 10 s, go: halt}
  halt: {do: [Brake], go: there}
ends: {there: {succeed: At the bend}}
"""
"""Few pictures: to draw and to search one takes 30 ms."""


class TestCamera(DetectorContract):
    @pytest.fixture
    def subject(self, tmp_path: Path) -> Subject:
        mission = tmp_path / "to_the_bend.yaml"
        mission.write_text(TO_THE_BEND, "utf-8")
        return Subject(DETECTORS.find("vision"), load_mission(mission), argument=str(CAMERA))

    @pytest.mark.thorough
    def test_it_can_begin_again_for_another_mission(self, subject: Subject) -> None:
        super().test_it_can_begin_again_for_another_mission(subject)

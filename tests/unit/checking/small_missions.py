"""Missions of a few lines, and what a check says of them."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import MissionCheck, check_mission

NEWT = Path(__file__).resolve().parents[2] / "robots" / "newt"

MISSION = """\
format: 1
mission: m
robot: pirate_ii
start: a
phases:
  a: {do: [ClampFront], go: e}
ends:
  e: {succeed: ok}
"""
"""The shortest mission of a shipped robot that succeeds."""

ENDS = "ends: {good: {succeed: Good}, bad: {fail: 'Bad: {cause}'}}\n"


def write(folder: Path, body: str, *, name: str = "m", robot: Path = NEWT) -> Path:
    """A mission file of the small robot with a head, and with ends unless the body has its own."""
    path = folder / f"{name}.yaml"
    ends = "" if "\nends:" in body else ENDS
    head = f"format: 1\nmission: {name}\nrobot: {robot}\n"
    path.write_text(head + body.lstrip("\n") + ends, encoding="utf-8")
    return path


def checked(folder: Path, body: str) -> MissionCheck:
    return check_mission(write(folder, body))


def told(check: MissionCheck) -> list[tuple[str, str]]:
    """Codes and severities in the order of the places."""
    return [(each.code, each.severity.word) for each in check.findings]


def only(check: MissionCheck, code: str) -> Finding:
    """The one finding with this code."""
    (found,) = (each for each in check.findings if each.code == code)
    return found

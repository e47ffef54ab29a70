"""Files written in a test, loaded, and what is said about them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from checking.small_missions import MISSION

from pirate_sm.core._loading import chart_exploration as chart_cache
from pirate_sm.core._loading.mission.loader import LoadedMission, load_mission
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot
from pirate_sm.core.errors import UsageError
from pirate_sm.core.kept_entries import Entries

ROOT = Path(__file__).resolve().parents[4]
NEWT = ROOT / "tests" / "robots" / "newt"


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Explored charts are kept where no other test and no user sees them."""
    folder = tmp_path_factory.getbasetemp() / "cache"
    monkeypatch.setattr(chart_cache, "charts", lambda: Entries(folder))
    return folder


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., LoadedMission]:
    """Writes a mission, and other files beside it by name, and loads it."""

    def write(text: str = MISSION, files: dict[str, str] | None = None, **options: Any):
        for name, content in (files or {}).items():
            (tmp_path / name).write_text(content, encoding="utf-8")
        mission = tmp_path / "m.yaml"
        mission.write_text(text, encoding="utf-8")
        return load_mission(mission, **options)

    return write


@pytest.fixture
def faults(load: Callable[..., LoadedMission], tmp_path: Path) -> Callable[..., list[str]]:
    """What is wrong with a mission: `file:line:col: message` of each fault, in order."""

    def find(text: str, files: dict[str, str] | None = None, **options: Any) -> list[str]:
        return said(lambda: load(text, files, **options), tmp_path)

    return find


@pytest.fixture
def newt(tmp_path: Path) -> Callable[..., list[str]]:
    """What is wrong with a small robot in whose files something has been put for something else."""

    def change(file: str, *swaps: tuple[str, str]) -> list[str]:
        return said(lambda: changed_newt(tmp_path, file, *swaps), tmp_path / "newt")

    return change


@pytest.fixture
def loaded_newt(tmp_path: Path) -> Callable[..., LoadedRobot]:
    """A small robot in whose files something has been put for something else."""
    return partial(changed_newt, tmp_path)


def changed_newt(folder: Path, file: str, *swaps: tuple[str, str]) -> LoadedRobot:
    robot = folder / "newt"
    shutil.copytree(NEWT, robot)
    text = (robot / file).read_text(encoding="utf-8")
    for old, new in swaps:
        assert old in text, f"nothing to swap: {old}"
        text = text.replace(old, new, 1)
    (robot / file).write_text(text, encoding="utf-8")
    return load_robot(robot)


def said(action: Callable[[], object], folder: Path) -> list[str]:
    """The faults that an action is refused for; none when it is not refused."""
    try:
        action()
    except LoadError as error:
        faults = [f"{each.place}: {each.message}" for each in error.problems]
    except UsageError as error:
        faults = [str(error)]
    else:
        faults = []
    return [fault.replace(f"{folder}/", "") for fault in faults]

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.core.registry import Plugin, Registry

FIRST = Plugin("ours", lambda: 1)
MODULE = """
from pirate_sm.core.errors import UsageError
from pirate_sm.core.registry import Plugin
def refusing():
    raise UsageError("not today")
THING = Plugin('theirs', lambda: 2)
RAISES = Plugin('theirs', lambda: {}['rig'])
LEAVES = Plugin('theirs', lambda: exit('gone'))
REFUSES = Plugin('theirs', refusing)
RETURNS = Plugin('theirs', lambda: 'two')
CALLS = Plugin('theirs', 3)
"""


@pytest.fixture
def registry() -> Registry[Callable[[], int]]:
    return Registry("thing", "pirate_sm.test_things", {"first": f"{__name__}:FIRST"}, int)


def installed(folder: Path, package: str, points: dict[str, str]) -> None:
    """A package of this name has these entry points, as pip leaves it."""
    (folder / "theirs.py").write_text(MODULE)
    metadata = folder / f"{package.replace('-', '_')}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    lines = [f"{name} = {value}" for name, value in points.items()]
    (metadata / "entry_points.txt").write_text("\n".join(["[pirate_sm.test_things]", *lines]))


def test_ours_are_found_without_a_search_through_what_is_installed(
    registry: Registry[Callable[[], int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def searched(**groups: str) -> None:
        raise AssertionError("metadata was read")

    monkeypatch.setattr("pirate_sm.core.registry.entry_points", searched)

    assert registry.find("first") is FIRST.make


@pytest.mark.thorough
def test_a_list_of_ours_loads_neither_the_simulator_nor_the_serial_link() -> None:
    code = (
        "import sys; from pirate_sm.running.wiring import BACKENDS; "
        "from pirate_sm.robot.detectors.registry import DETECTORS; "
        "print(len([*BACKENDS.listed(), *DETECTORS.listed()])); print(*sys.modules)"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    count, modules = told.stdout.splitlines()

    assert int(count) >= 7
    assert not {"numba", "numpy", "serial", "rosbags", "rich"} & set(modules.split())


def test_another_package_adds_a_name(
    registry: Registry[Callable[[], int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed(tmp_path, "their-things", {"second": "theirs:THING"})
    monkeypatch.syspath_prepend(str(tmp_path))

    assert registry.names == ["first", "second"]
    assert registry.find("second")() == 2
    assert registry.package_of("second") == "their-things"
    assert registry.package_of("first") == ""
    assert [(each.name, each.about) for each in registry.listed()] == [
        ("first", "ours"),
        ("second", "theirs"),
    ]


def test_our_names_cannot_be_taken_and_of_two_others_the_first_package_has_it(
    registry: Registry[Callable[[], int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed(tmp_path, "zebra", {"first": "theirs:THING", "second": "nowhere:THING"})
    installed(tmp_path, "ant", {"second": "theirs:THING"})
    monkeypatch.syspath_prepend(str(tmp_path))

    assert registry.find("first") is FIRST.make
    assert registry.package_of("second") == "ant"
    taken = [(each.name, each.package) for each in registry.listed() if "taken" in each.fault]
    assert taken == [("first", "zebra"), ("second", "zebra")]


def test_a_name_that_is_not_there_is_refused_with_what_was_meant(
    registry: Registry[Callable[[], int]],
) -> None:
    with pytest.raises(UsageError, match="there is no thing 'frist'; did you mean 'first'"):
        registry.find("frist")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("RAISES", "fails with KeyError: 'rig'"),
        ("LEAVES", "fails with SystemExit: gone"),
        ("RETURNS", "returns a value of type str, expected int"),
        ("CALLS", "fails with TypeError: 'int' object is not callable"),
    ],
)
def test_what_goes_wrong_in_another_package_names_it_and_its_entry_point(
    registry: Registry[Callable[[], int]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    why: str,
) -> None:
    installed(tmp_path, "their-things", {"second": f"theirs:{name}"})
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "theirs", raising=False)

    with pytest.raises(BackendError) as caught:
        registry.find("second")()

    whose = "the thing 'second' cannot be used: package their-things: theirs"
    assert str(caught.value) == f"{whose}:{name} {why}"


def test_what_another_package_refuses_is_said_in_its_words(
    registry: Registry[Callable[[], int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed(tmp_path, "their-things", {"second": "theirs:REFUSES"})
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "theirs", raising=False)

    with pytest.raises(UsageError, match=r"^not today$"):
        registry.find("second")()

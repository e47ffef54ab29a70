from __future__ import annotations

import json
import subprocess
import sys

import pytest

import pirate_sm

HEAVY = {"numba", "numpy", "pandas", "pydantic", "rich", "statemachine", "typer", "yaml"}


def modules_after(code: str) -> set[str]:
    result = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport json, sys; print(json.dumps(sorted(sys.modules)))"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return set(json.loads(result.stdout.splitlines()[-1]))


def test_importing_the_package_loads_nothing_else() -> None:
    found = modules_after("import pirate_sm")

    assert {name for name in found if name.startswith("pirate_sm")} == {"pirate_sm"}
    assert not HEAVY & found


@pytest.mark.thorough
def test_loading_and_checking_a_mission_needs_neither_the_simulator_nor_the_view() -> None:
    found = modules_after("import pirate_sm; pirate_sm.check(pirate_sm.load('mitre_bend'))")

    assert not {"numba", "numpy", "pandas", "rich", "typer", "textual"} & found


@pytest.mark.parametrize("name", pirate_sm.__all__)
def test_every_name_is_there_and_explained(name: str) -> None:
    assert getattr(pirate_sm, name).__doc__
    assert name in dir(pirate_sm)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        pirate_sm.fly  # noqa: B018

"""The lock, beside the ranges of pyproject.toml, and the parts of it that are installed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from locked import locked, ranges

ROOT = Path(__file__).resolve().parents[1]
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")
LOCK = (ROOT / "requirements.lock").read_text("utf-8")
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
GROUPS = PROJECT["dependency-groups"]
NAMES = [*PROJECT["project"]["optional-dependencies"], *GROUPS]
PINS = [Requirement(line.removesuffix(" \\")) for line in LOCK.splitlines() if line[0] not in " #"]


def applies(requirement: Requirement, python: str) -> bool:
    environment = {"python_version": python, "python_full_version": f"{python}.9"}
    return requirement.marker is None or requirement.marker.evaluate(
        {**default_environment(), **environment}
    )


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
@pytest.mark.parametrize("name", NAMES)
def test_no_belief_in_versions_that_nobody_tested(name: str, python: str) -> None:
    for each in map(Requirement, ranges([name])):
        if each.name == PROJECT["project"]["name"] or not applies(each, python):
            continue
        (pin,) = [
            pin for pin in PINS if pin.name == canonicalize_name(each.name) and applies(pin, python)
        ]
        (exact,) = pin.specifier
        assert exact.operator == "=="
        assert each.specifier.contains(exact.version), f"{each} is locked as {pin}"


def test_every_version_has_hashes_and_none_an_address() -> None:
    assert PINS
    for entry in re.split(r"^(?=\w)", LOCK, flags=re.M)[1:]:
        assert re.search(r"--hash=sha256:[0-9a-f]{64}", entry), entry
    assert not re.search(r"://|^-| @ |\bindex\b", LOCK, re.M)


def test_a_part_of_the_lock_is_what_its_extras_need_and_no_more() -> None:
    part = locked(LOCK, ["jit"])
    names = set(re.findall(r"^([\w.-]+)==", part, re.M))

    assert {"numba", "llvmlite", "pydantic-core", "numpy"} <= names
    assert not {"mypy", "mujoco", "pytest", "ziglang"} & names
    assert part.count("\nnumpy==") == LOCK.count("\nnumpy==")
    assert locked(LOCK, [name for name in NAMES if name != "all"]) == LOCK


def test_a_lock_that_lacks_something_is_refused() -> None:
    old = re.sub(r"^numba==", "number==", LOCK, flags=re.M)

    with pytest.raises(SystemExit, match="lacks numba: run make update"):
        locked(old, ["jit"])


def test_the_makefile_installs_extras_that_exist_and_locks_every_group() -> None:
    extras = re.findall(r"^\$\(VENV\)/\.ready-\w+: EXTRAS := (\S+)$", MAKEFILE, re.M)

    assert len(extras) > 5
    assert {name for each in extras for name in each.split(",")} <= {*NAMES}
    assert re.findall(r"--group (\S+)", MAKEFILE) == [*GROUPS]


def test_what_builds_the_package_is_locked() -> None:
    assert {*PROJECT["build-system"]["requires"]} <= {*GROUPS["build"]}

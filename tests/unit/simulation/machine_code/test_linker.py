"""Where libraries are built, and what is told where one is not."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def builder() -> Any:
    """The module, which brings numba and is imported only for these tests."""
    return import_module("pirate_sm.simulation.machine_code.builder")


def test_on_other_systems_nothing_is_built(
    builder: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "platform", "sunos5")

    assert builder.this_target() is None
    with pytest.raises(RuntimeError, match=f"nothing is built for {sysconfig.get_platform()}"):
        builder.link([], tmp_path / "library")


def test_a_c_library_that_numba_is_not_made_for_counts_as_another_system(
    builder: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(builder.platform, "machine", lambda: "x86_64")
    for name, there in (("glibc", True), ("", False)):
        monkeypatch.setattr(builder.platform, "libc_ver", lambda name=name: (name, ""))
        assert (builder.this_target() is not None) == there


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (
            "error: undefined symbol: PyErr_SetString\n    note: referenced by f\n"
            "error: undefined symbol: NRT_Free\n",
            r"more of numba than support.c has \(NRT_Free, PyErr_SetString\)",
        ),
        ("No module named ziglang\n", "zig did not link it: No module named ziglang"),
        ("", "zig did not link it: no message"),
    ],
)
def test_a_failure_names_its_cause(
    builder: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, told: str, said: str
) -> None:
    def failing(command: list[str], **options: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 1, "", told)

    monkeypatch.setattr(
        builder, "this_target", lambda: builder.MachineTarget("x86_64-linux-gnu", "any")
    )
    monkeypatch.setattr(builder.subprocess, "run", failing)

    with pytest.raises(RuntimeError, match=said):
        builder.link([], tmp_path / "library")

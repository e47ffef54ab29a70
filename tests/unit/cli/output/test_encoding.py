"""Terminals that lack some signs are written to all the same."""

from __future__ import annotations

import io
import subprocess
import sys
from typing import Any

import pytest

from pirate_sm.cli.output.terminal import degrade, shows_signs

from ..conftest import NEWT, ROOT


def stream(encoding: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(), encoding=encoding)


def written(out: io.TextIOWrapper, text: str) -> str:
    out.write(text)
    out.flush()
    return out.buffer.getvalue().decode(out.encoding)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("ascii", "Off -> On, 4 x, 28 deg ? v"),
        ("latin-1", "Off -> On, 4 ×, 28° ? v"),
        ("utf-8", "Off → On, 4 ×, 28° 管 ✓"),
    ],
)
def test_signs_that_the_encoding_lacks_become_something_alike(encoding: str, shown: str) -> None:
    out = stream(encoding)
    degrade(out)

    assert written(out, "Off → On, 4 ×, 28° 管 ✓") == shown


def test_pictures_are_drawn_where_every_sign_can_be_written() -> None:
    assert shows_signs(stream("utf-8"))
    assert not shows_signs(stream("latin-1"))
    assert not shows_signs(None)


@pytest.mark.thorough
def test_a_run_on_a_latin_1_output_ends_as_elsewhere() -> None:
    code = "from pirate_sm.cli.start import run_main; run_main()"
    options: dict[str, Any] = {"cwd": ROOT, "capture_output": True, "timeout": 60}
    result = subprocess.run(
        [sys.executable, "-c", code, str(NEWT / "patrol.yaml"), "--backend", "trace"],
        env={"PYTHONIOENCODING": "latin-1", "PYTHONPATH": str(ROOT), "PIRATE_SM_CACHE": ""},
        check=False, **options,
    )  # fmt: skip

    assert result.returncode == 0
    assert b" -> " in result.stdout
    assert b"Traceback" not in result.stderr

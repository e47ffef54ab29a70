"""Damaged machine code on disk costs a compilation, not the run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = """
from pirate_sm.simulation.machine_code import compiled, is_kept

@compiled
def inner(x: float) -> float:
    return x + 1.0

@compiled
def outer(x: float) -> float:
    return 2.0 * inner(x)

print(is_kept(outer), outer(20.0))
"""


def run(folder: Path) -> str:
    script = folder / "doubling.py"
    if not script.exists():
        script.write_text(SOURCE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "kept")},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout.strip() or done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc", "*.nb?"])
@pytest.mark.parametrize("content", [b"", b"junk", None], ids=["empty", "junk", "cut"])
def test_damaged_machine_code_is_made_again(
    tmp_path: Path, pattern: str, content: bytes | None
) -> None:
    assert run(tmp_path) == "False 42.0"
    assert run(tmp_path) == "True 42.0"
    for path in (tmp_path / "kept").rglob(pattern):
        whole = path.read_bytes()
        path.write_bytes(whole[: len(whole) // 2] if content is None else content)

    assert run(tmp_path).endswith(" 42.0")
    assert run(tmp_path) == "True 42.0"


CALLED = """
from pirate_sm.simulation.machine_code import compiled

@compiled
def tripled(x: float) -> float:
    return 3.0 * x
"""

CALLING = """
from pirate_sm.simulation.machine_code import compiled, is_kept
from called import tripled
from constants import MORE

@compiled
def more(x: float) -> float:
    return tripled(x) + MORE

print(is_kept(more), more(2.0))
"""


@pytest.mark.slow
def test_an_edit_of_what_a_function_calls_or_uses_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "called.py").write_text(CALLED, encoding="utf-8")
    (tmp_path / "constants.py").write_text("MORE = 1.0", encoding="utf-8")
    (tmp_path / "doubling.py").write_text(CALLING, encoding="utf-8")
    assert [run(tmp_path), run(tmp_path)] == ["False 7.0", "True 7.0"]

    (tmp_path / "constants.py").write_text("MORE = 10.0", encoding="utf-8")
    assert [run(tmp_path), run(tmp_path)] == ["False 16.0", "True 16.0"]

    (tmp_path / "called.py").write_text(CALLED.replace("3.0", "30.0"), encoding="utf-8")
    assert [run(tmp_path), run(tmp_path)] == ["False 70.0", "True 70.0"]

"""Machine code on disk: damaged, it costs a compilation, not the run; outdated, it is not used."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

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
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "kept"), "PIRATE_SM_JIT": "1"},
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


def test_an_edit_in_a_file_that_is_imported_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    just_in_time = pytest.importorskip("pirate_sm.simulation.machine_code.just_in_time")

    def stamp(digest: str) -> Any:
        monkeypatch.setattr(just_in_time, "_stamp", lambda module: digest)
        made: Any = just_in_time.compiled_when_called(_half)
        return made._cache._cache_file._source_stamp

    assert stamp("before") == stamp("before")
    assert stamp("before") != stamp("after")


def _half(x: float) -> float:
    return x / 2.0

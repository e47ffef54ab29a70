"""Builds the library with the machine code of the entry points; runs while the package is built.

    python -m pirate_sm.simulation.machine_code.builder

builds it into the source tree; that needs numba and ziglang.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from pirate_sm.simulation.machine_code.built_library import FILE, FOLDER
from pirate_sm.simulation.machine_code.decorator import JIT_VARIABLE
from pirate_sm.simulation.machine_code.entry_points import ENTRY_POINTS
from pirate_sm.simulation.machine_code.linker import link
from pirate_sm.simulation.machine_code.sources import PACKAGE, files_behind

_SUPPORT = FOLDER / "support.c"
_OBJECT_FILE = f"{__package__}.object_file"

SOURCES = (
    *files_behind([_OBJECT_FILE, *(entry.module for entry in ENTRY_POINTS)]),
    _SUPPORT.relative_to(PACKAGE).as_posix(),
)
"""The files that the library is made of, below the package."""


def build(into: Path) -> None:
    """Build the library.

    Args:
        into: Its file, which is replaced only when the new one is complete.

    Raises:
        RuntimeError: It cannot be built; the message says why.
    """
    with tempfile.TemporaryDirectory(prefix="pirate_sm-") as name:
        folder = Path(name)
        compiled = folder / "functions.o"
        _compile(compiled, folder / "cache")
        part = into.with_name(f".{into.name}.{os.getpid()}")
        try:
            link([compiled, _SUPPORT], part)
            part.replace(into)
        finally:
            part.unlink(missing_ok=True)


def _compile(into: Path, cache: Path) -> None:
    """Compile the functions to an object file."""
    # numba reads its settings when it is imported. Its usual cache may hold functions as they were.
    settings = {
        JIT_VARIABLE: "1",
        "NUMBA_CACHE_DIR": str(cache),
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CPU_NAME": "generic",
        "PYTHONPATH": os.pathsep.join([str(PACKAGE.parent), *filter(None, sys.path)]),
    }
    command = [sys.executable, "-m", _OBJECT_FILE, str(into)]
    done = subprocess.run(
        command, env=os.environ | settings, capture_output=True, text=True, check=False
    )
    if done.returncode:
        print(done.stderr, file=sys.stderr)
        errors = re.findall(r"^[\w.]*Error\b.*", done.stderr, re.MULTILINE) or ["it was stopped"]
        raise RuntimeError(f"the functions were not compiled: {errors[-1]}")


if __name__ == "__main__":
    build(FOLDER / FILE)

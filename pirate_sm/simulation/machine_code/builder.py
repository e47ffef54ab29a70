"""Builds the library with the machine code of the entry points; runs while the package is built.

    python -m pirate_sm.simulation.machine_code.builder

builds it into the source tree; that needs numba and ziglang.
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pirate_sm.simulation.machine_code.built_library import (
    FILE,
    FOLDER,
    JIT_VARIABLE,
    PACKAGE,
    files_behind,
)
from pirate_sm.simulation.machine_code.entry_points import ENTRY_POINTS

# --- linker --------------------------------------------------------------------------------------


class MachineTarget(NamedTuple):
    """A kind of machine that libraries are built for.

    Attributes:
        zig: Its name for zig.
        tag: Its name in the file names of wheels.
    """

    zig: str
    tag: str


# The oldest C library and system that zig can be asked for and that Python >= 3.11 runs on.
_TARGETS = {
    ("linux", "x86_64"): MachineTarget("x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64"),
    ("linux", "aarch64"): MachineTarget("aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64"),
    ("darwin", "arm64"): MachineTarget("aarch64-macos.11.0", "macosx_11_0_arm64"),
}


def this_target() -> MachineTarget | None:
    """Return the target that this Python runs on; None if its tools are not to be had here."""
    odd_c_library = sys.platform == "linux" and platform.libc_ver()[0] != "glibc"
    if odd_c_library or sys.maxsize < 2**32 or sys.implementation.name != "cpython":
        return None
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        return None
    return _TARGETS.get((sys.platform, platform.machine()))


def link(parts: Sequence[Path], into: Path) -> None:
    """Link object files and C files to a shared library.

    Raises:
        RuntimeError: It cannot be linked; the message says why.
    """
    target = this_target()
    if target is None:
        raise RuntimeError(f"nothing is built for {sysconfig.get_platform()}")
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig, "-O2", "-shared"]
    command += ["-fPIC", "-s"]
    if sys.platform == "linux":  # elsewhere a name that is left open is an error anyway
        command += ["-fvisibility=hidden", "-Wl,--no-undefined"]
    command += [*map(str, parts), "-lm", "-o", str(into)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(_why(done.stderr))


def _why(printed: str) -> str:
    """Return the cause of a failure from what zig has printed."""
    missing = sorted(set(re.findall(r"undefined symbol: (\S+)", printed)))
    if missing:
        return (
            f"a function needs more of numba than support.c has ({', '.join(missing)}); "
            "compute in loops what it computes with whole arrays or slices"
        )
    lines = printed.strip().splitlines() or ["no message"]
    return f"zig did not link it: {lines[-1]}"


# --- builder -------------------------------------------------------------------------------------


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

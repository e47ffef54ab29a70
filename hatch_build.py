"""Builds the simulator's machine code with the package (decision record 65)."""

from __future__ import annotations

import os
import sys
import tempfile
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))  # the package says what is built, and how

from pirate_sm.simulation.machine_code import builder, built_library
from pirate_sm.simulation.machine_code import builder as linker

WISH = os.environ.get("PIRATE_SM_BUILD", "")
"""`never` builds no machine code; with `always` nothing is installed where it cannot be built."""


class MachineCodeHook(BuildHookInterface[Any]):
    """Puts the library into wheels, and into the source tree for an editable installation.

    Where it cannot be built, the package is installed without it and with the reason, which the
    simulator tells: it then needs the extra `jit`.
    """

    def dependencies(self) -> list[str]:
        """Return the tools of the build; none where nothing is built or all is built already."""
        if WISH == "never" or linker.this_target() is None or self._is_built():
            return []
        project = tomllib.loads((Path(self.root) / "pyproject.toml").read_text("utf-8"))
        return list(project["dependency-groups"]["machine-code"])

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library, or write down why there is none."""
        target = linker.this_target()
        if version == "editable":
            if not self._is_built():
                self._build(built_library.FOLDER)
            return
        self._made = tempfile.TemporaryDirectory(prefix="pirate_sm-")
        folder = built_library.FOLDER if self._is_built() else self._build(Path(self._made.name))
        inside = built_library.FOLDER.relative_to(self.root).as_posix()
        for name in (built_library.FILE, built_library.REASON_FILE):
            if (folder / name).is_file():
                build_data["force_include"][str(folder / name)] = f"{inside}/{name}"
        if (folder / built_library.FILE).is_file() and target is not None:
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{target.tag}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what the wheel was made of."""
        if version != "editable":
            self._made.cleanup()

    def _is_built(self) -> bool:
        """Return whether the source tree holds a library of its sources."""
        return built_library.find_library().library is not None

    def _build(self, folder: Path) -> Path:
        """Build the library into a folder, or the reason why there is none; return the folder.

        Raises:
            RuntimeError: It cannot be built and was asked for.
        """
        made, reason = folder / built_library.FILE, folder / built_library.REASON_FILE
        try:
            if WISH == "never":
                raise RuntimeError("PIRATE_SM_BUILD=never was set when pirate_sm was installed")
            builder.build(made)
            reason.unlink(missing_ok=True)
        except (OSError, RuntimeError) as error:
            if WISH == "always":
                raise
            self.app.display_warning(f"The simulator's machine code is not built: {error}")
            with suppress(OSError):  # an editable installation of a tree that is only read
                made.unlink(missing_ok=True)
                reason.write_text(f"its machine code is not built: {error}\n", encoding="utf-8")
        return folder

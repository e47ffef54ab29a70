"""Installs packages into a folder as pip would, without pip: their modules and their metadata."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

EXAMPLE = Path(__file__).resolve().parents[1] / "example_backend"


def install(source: Path, target: Path) -> None:
    """The package of a source tree stands in the target folder, with its entry points."""
    project = tomllib.loads((source / "pyproject.toml").read_text("utf-8"))["project"]
    module = project["name"].replace("-", "_")
    shutil.copytree(source / module, target / module)
    install_metadata(target, project["name"], project["entry-points"])


def install_metadata(target: Path, name: str, groups: dict[str, dict[str, str]]) -> None:
    """The target folder says of a package of this name that it has these entry points."""
    folder = target / f"{name.replace('-', '_')}-1.0.dist-info"
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = []
    for group, points in groups.items():
        lines += [f"[{group}]", *(f"{point} = {value}" for point, value in points.items()), ""]
    (folder / "entry_points.txt").write_text("\n".join(lines))

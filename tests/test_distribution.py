"""What pyproject.toml says of the package, beside what the package is."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
OF_DEVELOPERS = {"bench", "browser", "dev", "docs", "mutants"}
PIRATE = "from pirate_sm.cli.entry import main; main()"

NEEDING = {
    ("campaign", "pyarrow"): (PIRATE, "campaign", "campaigns/bend.yaml", "-o", "{here}"),
    ("campaign", "distributed"): (PIRATE, "campaign", "campaigns/bend.yaml", "-o", "{here}"),
    ("gym", "gymnasium"): ("import pirate_sm.learning",),
    ("jit", "numba"): (PIRATE, "run", "mitre_bend", "--no-record"),
    ("live", "foxglove"): (PIRATE, "run", "mitre_bend", "--backend", "trace", "--live"),
    ("physics", "mujoco"): (PIRATE, "run", "mitre_bend", "--backend", "physics"),
    ("serial", "serial"): (PIRATE, "doctor", "--port", "{here}/no_port"),
    ("serial", "rosbags"): (PIRATE, "run", "mitre_bend", "--backend", "bay"),
    ("vision", "cv2"): (PIRATE, "camera", "look", "synthetic"),
}
"""Something that needs a package of an extra: a line of Python and its arguments."""


def test_all_is_every_extra_of_a_user() -> None:
    (whole,) = EXTRAS["all"]
    chosen = whole.removeprefix("pirate-sm[").removesuffix("]").split(",")

    assert chosen == sorted({*EXTRAS} - OF_DEVELOPERS - {"all"})
    assert {extra for extra, _ in NEEDING} == {*chosen}


@pytest.mark.parametrize(("extra", "package"), NEEDING)
def test_what_needs_a_missing_extra_names_what_installs_it(
    extra: str, package: str, tmp_path: Path
) -> None:
    code, *arguments = NEEDING[extra, package]
    hidden = f"import os, sys; sys.modules[{package!r}] = None; os.environ['PIRATE_SM_JIT'] = '1'; "
    done = subprocess.run(
        [sys.executable, "-c", hidden + code, *(each.format(here=tmp_path) for each in arguments)],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip

    assert f"pip install 'pirate-sm[{extra}]'" in done.stderr
    if arguments:
        assert done.returncode == 2
        assert "Traceback" not in done.stderr


def test_texts_name_extras_that_exist() -> None:
    texts = [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "pirate_sm").rglob("*.py"),
    ]
    named = {
        name
        for text in texts
        for listed in re.findall(r"pirate-sm\[([a-z,]+)\]", text.read_text("utf-8"))
        for name in listed.split(",")
    }

    assert "serial" in named
    assert named <= {*EXTRAS}


def test_everything_vendored_has_its_licence_beside_it() -> None:
    folders = {
        file.parent
        for file in (ROOT / "pirate_sm").rglob("*")
        if re.search(r"\.min\.(js|css)$|^uPlot|^three", file.name) and file.is_file()
    }
    licensed = {
        path.parent for pattern in PROJECT["license-files"] for path in ROOT.glob(pattern)
    } - {ROOT}

    assert {folder.name for folder in folders} == {"three-0.170.0", "uplot-1.6.32"}
    assert folders == licensed
    for folder in folders:
        text = (folder / "LICENSE").read_text("utf-8")
        assert "Permission is hereby granted, free of charge" in text
        assert "Copyright" in text

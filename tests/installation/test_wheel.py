"""The package as it is installed: from its source archive, into an environment of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SDIST = "import sys; from hatchling.build import build_sdist; print(build_sdist(sys.argv[1]))"

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1200)]


class Environment:
    """A Python environment.

    Attributes:
        programs: The folder of its programs.
    """

    def __init__(self, folder: Path) -> None:
        venv.create(folder, with_pip=True)
        self.programs = folder / "bin"

    def run(
        self, program: str, *arguments: object, cwd: Path, **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """Run one of its programs, with nothing of the tests' own environment."""
        own = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        return subprocess.run(
            [str(self.programs / program), *map(str, arguments)],
            cwd=cwd, env={**own, **variables}, capture_output=True, text=True, check=False,
        )  # fmt: skip

    def install(self, what: object, cwd: Path, **variables: str) -> None:
        done = self.run("python", "-m", "pip", "install", what, cwd=cwd, **variables)
        assert done.returncode == 0, done.stdout + done.stderr

    @property
    def packages(self) -> Path:
        """Where packages are installed."""
        (found,) = self.programs.parent.glob("lib/python*/site-packages")
        return found

    @property
    def tags(self) -> list[str]:
        """The tags of the installed package, and whether it is for any machine."""
        (wheel,) = self.packages.glob("pirate_sm-*.dist-info/WHEEL")
        return wheel.read_text("utf-8").splitlines()


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source archive, as it is published."""
    folder = tmp_path_factory.mktemp("archive")
    builder = Environment(folder / "builder")
    builder.install("hatchling>=1.27,<2", folder)
    made = builder.run("python", "-c", SDIST, folder, cwd=ROOT)
    assert made.returncode == 0, made.stderr
    return folder / made.stdout.split()[-1]


def test_the_archive_holds_sources_and_nothing_that_was_built(archive: Path) -> None:
    listed = subprocess.run(["tar", "-tzf", archive], capture_output=True, text=True, check=True)
    names = {name.partition("/")[2] for name in listed.stdout.splitlines()}

    assert {"hatch_build.py", "pirate_sm/simulation/machine_code/support.c"} <= names
    assert not [name for name in names if name.endswith((".library", "not_built.txt"))]


@pytest.mark.skipif(sys.platform != "linux", reason="names the tag of Linux")
def test_the_simulator_runs_as_installed(archive: Path, tmp_path: Path) -> None:
    here = Environment(tmp_path / "environment")
    here.install(archive, tmp_path, PIRATE_SM_BUILD="always")

    assert "Root-Is-Purelib: false" in here.tags
    assert [line for line in here.tags if line.startswith("Tag: py3-none-manylinux_2_17_")]
    assert not list(here.packages.glob("numba*"))
    done = here.run("pirate-run", "mitre_bend", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "mitre_bend: succeeded" in done.stdout


def test_without_its_machine_code_it_is_installed_and_says_what_is_missing(
    archive: Path, tmp_path: Path
) -> None:
    here = Environment(tmp_path / "environment")
    here.install(archive, tmp_path, PIRATE_SM_BUILD="never")

    assert {"Root-Is-Purelib: true", "Tag: py3-none-any"} <= set(here.tags)
    done = here.run("pirate-run", "mitre_bend", "--quiet", "--backend", "trace", cwd=tmp_path)
    assert done.returncode == 0
    done = here.run("pirate-run", "mitre_bend", "--quiet", cwd=tmp_path)
    assert done.returncode == 2
    assert "PIRATE_SM_BUILD=never was set when pirate_sm was installed" in done.stderr
    assert "pip install 'pirate-sm[jit]'" in done.stderr

"""Follows a page of the documentation as its reader does, and compares what is printed."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conformance.installed import install
from followed_page import Command, Edit, apply
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands, only_run
from pirate_sm.core import library
from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.detectors.registry import DETECTORS
from pirate_sm.running.wiring import BACKENDS
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

ROOT = Path(__file__).resolve().parents[1]
PROGRAMS = {"pirate": "main", "pirate-run": "run_main"}
SHELL = """#!/bin/sh
exec {python} -c 'from pirate_sm.cli.start import {name}; {name}()' "$@"
"""


class Reader:
    """Somebody who follows a guide: writes its files, runs its commands, compares what they print.

    Commands of this program run in this process; what a command line adds to them (a pipe, a
    process in the background) is left to a shell. ``pip install`` only copies the package.

    Attributes:
        in_real_time: Whether what a link leads to is run so; otherwise with the same driver and
            the same emulated robot in virtual time. The bay that a guide starts then ends as soon
            as it is ready.
    """

    in_real_time = False

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self._patch = patch
        self.folder = folder / "work"
        self.folder.mkdir()
        self.site = folder / "site"
        self.site.mkdir()
        self.programs = folder / "bin"
        self.programs.mkdir()
        self.behind: list[subprocess.Popen[str]] = []
        for program, name in PROGRAMS.items():
            file = self.programs / program
            file.write_text(SHELL.format(python=sys.executable, name=name), "utf-8")
            file.chmod(0o755)

    def follow(self, step: Edit | Command) -> None:
        if isinstance(step, Edit):
            apply(step, self.folder)
            return
        exits, printed = self.run(step.line)
        if self.in_real_time and exits != step.exits and step.line.startswith("pirate doctor"):
            exits, printed = self.run(step.line)  # a busy machine's emulation may be too slow
        assert exits == step.exits, f"$ {step.line}\n{printed}"
        shown = "".join(f"{line.rstrip()}\n" for line in printed.strip("\n").splitlines())
        expected = "".join(map(_pattern, step.prints))
        assert re.fullmatch(expected, shown), f"$ {step.line}\n{shown}"

    def run(self, line: str) -> tuple[int, str]:
        """Return the exit code of a command and what it prints."""
        if line.startswith("pip install "):
            install(self.folder / line.rsplit(maxsplit=1)[-1], self.site)
            for registry in (BACKENDS, DETECTORS):
                registry.forget()
            return 0, ""
        if line.endswith("&"):
            return 0, self._behind(line.removesuffix("&"))
        if not self.in_real_time:
            line = re.sub("--backend serial --port bay", "--backend bay", line)
            self._patch.setattr("pirate_sm.cli.commands.doctor.guarded_port", self._port)
        program, *arguments = shlex.split(line)
        if program in PROGRAMS and not {"|", ">", "||"} & set(arguments):
            result = CliRunner().invoke(
                commands if program == "pirate" else only_run(), arguments, env={"COLUMNS": "100"}
            )
            return result.exit_code, result.output
        done = subprocess.run(
            ["bash", "-c", line], **self._where, stderr=subprocess.STDOUT, check=False
        )
        return done.returncode, done.stdout

    @property
    def _where(self) -> dict[str, object]:
        path = os.pathsep.join([str(self.programs), str(Path(sys.executable).parent)])
        return {
            "cwd": self.folder,
            "stdout": subprocess.PIPE,
            "text": True,
            "env": os.environ
            | {
                "PATH": os.pathsep.join([path, os.environ["PATH"]]),
                "PYTHONPATH": os.pathsep.join([str(ROOT), str(self.site)]),
                "COLUMNS": "100",
                "PRE_COMMIT_HOME": str(self.folder.parent / "hooks"),
            },
        }

    def _behind(self, line: str) -> str:
        """Start a process that goes on; return its first line, after which it is ready."""
        process = subprocess.Popen(["bash", "-c", f"exec {line}"], **self._where)
        self.behind.append(process)
        assert process.stdout is not None
        ready = process.stdout.readline()
        if "pirate bay" in line and not self.in_real_time:
            process.terminate()
        return ready

    def _port(self, plan: LinkPlan, url: str, baud: int | None, stay_s: float) -> VirtualPort:
        """Return a port to a bay of its own, instead of the one that a guide has started."""
        assert url == "bay"
        loaded = load_robot(self.folder / "my_pirate")
        texts = message_texts(loaded.folder, loaded.profile)
        bay = VirtualBay(loaded.profile, load_pipe(library.pipes()[0])[0], texts, Switches())
        return VirtualPort(bay, plan.serial.heartbeat_within, plan.wanted)


def _pattern(line: str) -> str:
    """Return what a line of a page stands for: `…` for anything, alone for any lines."""
    if line.strip() == "…":
        return r"(?:.*\n)*?"
    return ".*".join(re.escape(part) for part in line.rstrip().split("…")) + "\n"


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Reader]:
    someone = Reader(tmp_path, monkeypatch)
    monkeypatch.chdir(someone.folder)
    monkeypatch.syspath_prepend(str(someone.site))
    yield someone
    for process in someone.behind:
        process.terminate()
        process.communicate()
    for registry in (BACKENDS, DETECTORS):
        registry.forget()

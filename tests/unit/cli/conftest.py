from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from pirate_sm.cli.entry import commands, only_run
from pirate_sm.running.runtime.ending import BY_SIGNAL

from .forked import ForkedRun

ROOT = Path(__file__).resolve().parents[3]
NEWT = ROOT / "tests" / "robots" / "newt"


@pytest.fixture
def pirate_run() -> Callable[..., Result]:
    """Calls `pirate-run` in this process; standard output is no terminal."""
    return lambda *arguments: CliRunner().invoke(only_run(), [str(each) for each in arguments])


@pytest.fixture
def pirate() -> Callable[..., Result]:
    """Calls `pirate` in this process."""
    return lambda *arguments: CliRunner().invoke(commands, [str(each) for each in arguments])


def _usual_signals() -> None:
    """A child hears signals even where the tests themselves were started to ignore them."""
    for number in BY_SIGNAL:
        signal.signal(number, signal.SIG_DFL)


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts `pirate-run` as a process of its own, with pipes."""
    started: list[subprocess.Popen[str]] = []

    def start_it(*arguments: Any, **options: Any) -> subprocess.Popen[str]:
        process = ForkedRun(
            [*map(str, arguments)],
            stdin=subprocess.DEVNULL,
            stdout=options.pop("stdout", subprocess.PIPE),
            stderr=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=os.environ,
            preexec_fn=_usual_signals,
            **options,
        )
        started.append(process)
        return process

    yield start_it
    for process in started:
        process.kill()
        process.communicate()

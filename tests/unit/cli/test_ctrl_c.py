"""Ctrl-C at any moment: no traceback, and nothing said that is not so."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest
from representative import thorough_but

from pirate_sm.cli import start

from .conftest import NEWT, ROOT


def test_ctrl_c_while_the_commands_are_loaded_ends_the_process_without_a_traceback() -> None:
    code = """
import signal, sys
class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == "typer":
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Interrupts())
from pirate_sm.cli.start import run_main
run_main()
"""
    result = subprocess.run(
        [sys.executable, "-c", code, str(NEWT / "patrol.yaml")],
        capture_output=True, text=True, check=False, timeout=60,
        env={"PYTHONPATH": str(ROOT), "PATH": "", "PIRATE_SM_CACHE": ""},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip

    assert result.returncode == -signal.SIGINT
    assert result.stderr == ""


@pytest.mark.parametrize(
    ("command", "becomes", "says"),
    thorough_but(
        [
            ("run", "raise", "interrupted, nothing has moved\n"),
            ("check", "raise RuntimeError", "interrupted\n"),
        ],
        [
            ("run", "raise", "interrupted, nothing has moved\n"),
            ("run", "raise RuntimeError", "interrupted, nothing has moved\n"),
            ("run", "pass", "interrupted, nothing has moved\n"),
            ("check", "raise", "interrupted\n"),
            ("check", "raise RuntimeError", "interrupted\n"),
        ],
    ),
)
def test_ctrl_c_while_a_file_is_read_ends_the_command(
    command: str, becomes: str, says: str
) -> None:
    """Compiled code that checks a file may turn the exception into another one, or drop it."""
    code = f"""
import signal
import pirate_sm.core._loading.yaml.document as document
read = document.read_document
def interrupted(*given, **more):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        {becomes}
    return read(*given, **more)
document.read_document = interrupted
from pirate_sm.cli.start import main
main()
"""
    result = subprocess.run(
        [sys.executable, "-c", code, command, str(NEWT / "patrol.yaml")],
        capture_output=True, text=True, check=False, timeout=60,
        env={"PYTHONPATH": str(ROOT), "PATH": "", "PIRATE_SM_CACHE": ""},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip

    assert (result.returncode, result.stdout, result.stderr) == (130, "", says)


def test_ctrl_c_is_ignored_once_the_command_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr("pirate_sm.cli.entry.main", lambda: None)
    try:
        start.main()
        signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)

"""`pirate completion`: prints the script with which a shell completes our command lines."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli import completion
from pirate_sm.cli.options.files import CompletionOptions


def print_script(options: CompletionOptions) -> int:
    """Print the script for a shell; return the exit code."""
    folder = Path(completion.__file__).with_name("scripts")
    print((folder / f"script.{options.shell}").read_text("utf-8"), end="")
    return 0

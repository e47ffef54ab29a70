"""The table of commands."""

from __future__ import annotations

from dataclasses import fields
from importlib import import_module
from typing import Any, get_type_hints

import pytest

from pirate_sm.cli.entry import COMMANDS


def found(package: str, at: str) -> Any:
    module, _, name = at.partition(":")
    return getattr(import_module(f"pirate_sm.cli.{package}.{module}"), name)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_work_of_a_command_takes_its_options_and_gives_an_exit_code(command: str) -> None:
    options_at, work_at = COMMANDS[command]

    options, work = found("options", options_at), found("commands", work_at)

    assert get_type_hints(
        work, {**vars(import_module(work.__module__)), options.__name__: options}
    ) == {"options": options, "return": int}
    assert {each.name for each in fields(options)} & {"debug", "version"}

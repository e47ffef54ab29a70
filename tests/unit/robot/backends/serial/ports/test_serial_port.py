"""What is said of a port that cannot be opened: each cause has a sentence of its own."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import serial

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.serial_port import SerialPort

from ..bench import Bench


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[str]:
    """The name of a port with a device that talks."""
    with Bench(tmp_path / "tty") as bench:
        yield bench.name


def refusal(name: str) -> str:
    with pytest.raises(BackendError) as caught:
        SerialPort(name, 57600).open()
    return str(caught.value)


@pytest.fixture
def places(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "file").touch()
    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        free = server.getsockname()[1]  # nobody listens there once it is closed
    return {
        "missing": str(tmp_path / "missing"),
        "beneath a file": str(tmp_path / "file" / "tty"),
        "directory": str(tmp_path),
        "file": str(tmp_path / "file"),
        "null": "/dev/null",
        "nothing": " ",
        "no scheme": "nonsense://x",
        "no option": "loop://?x=1",
        "no number": "socket://127.0.0.1:99999",
        "nobody": f"socket://127.0.0.1:{free}",
    }


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("missing", "there is no port {}; there "),
        ("beneath a file", "there is no port {}; there "),
        ("directory", "{} is a directory and no serial port"),
        ("file", "{} is a file and no serial port"),
        ("null", "{} is not a serial port, or nothing is connected to it"),
        ("nothing", "the name of the port is empty"),
        ("no scheme", "{} cannot be a serial port: invalid URL, protocol 'nonsense' not known"),
        ("no option", "{} is not an address that pyserial can use, such as socket://HOST:PORT"),
        ("no number", "{} is not an address that pyserial can use, such as socket://HOST:PORT"),
        ("nobody", "nothing listens at {}: is the program there running?"),
    ],
)
def test_a_wrong_port_is_told_as_what_it_is(places: dict[str, str], place: str, told: str) -> None:
    said = refusal(places[place])

    assert said.startswith(told.format(places[place]))
    assert "\n" not in said


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (errno.EACCES, "you may not use {}: join the group that owns it"),
        (errno.EBUSY, "{} is in use by another program"),
        (errno.EIO, "{} is not a serial port, or nothing is connected to it"),
    ],
)
def test_a_port_that_may_not_be_used_now_is_told_as_such(
    monkeypatch: pytest.MonkeyPatch, terminal: str, number: int, told: str
) -> None:
    opened = os.open

    def refuse(path: Any, *arguments: Any, **options: Any) -> int:
        if path == terminal:
            raise OSError(number, os.strerror(number))
        return opened(path, *arguments, **options)

    monkeypatch.setattr(os, "open", refuse)

    assert refusal(terminal).startswith(told.format(terminal))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("Could not open port x: [Errno 113] No route to host", "cannot be reached: is the host"),
        ("Could not open port x: timed out", "cannot be reached: is the host on"),
        ("Could not open port x: [Errno -2] Name or service not known", "has no known address"),
    ],
)
def test_a_host_that_is_not_there_is_told_as_such(
    monkeypatch: pytest.MonkeyPatch, words: str, told: str
) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise serial.SerialException(words)

    monkeypatch.setattr(serial, "serial_for_url", refuse)

    assert told in refusal("socket://robot:4000")


def test_a_port_has_one_user_and_is_free_afterwards(terminal: str) -> None:
    first = SerialPort(terminal, 57600)
    first.open()

    assert refusal(terminal).startswith(f"{terminal} is in use by another program")
    first.close()
    first.open()
    first.close()

"""Clients of the detector's socket, turn by turn; over a real socket: test_socket_detector.py."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.robot.detectors.socket_detector import (
    LONGEST_LINE,
    Address,
    LineError,
    Listener,
    _Client,
)

FULL = b" " * (LONGEST_LINE - 1) + b"\n"
"""All that is read in a turn, and no word."""


class Program:
    """A program that is connected, what it is heard to say, and what is refused."""

    def __init__(self, token: str = "") -> None:
        self.listener = Listener(Address(), token)
        self.link, ours = socket.socketpair()
        self.link.settimeout(0.0)
        ours.setblocking(False)
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1)  # a few answers fill it
        self.listener._clients.append(_Client(ours, trusted=not token))
        self.heard: list[bytes] = []

    def turn(self, sent: bytes = b"") -> list[str]:
        """Send this, let it be read once, and return why lines were refused."""
        self.link.sendall(sent)
        return self.listener.poll(self.take)

    def take(self, line: bytes) -> None:
        if line.startswith(b"!"):
            raise LineError(f"no such word: {line.decode()}")
        self.heard.append(line)

    @property
    def stays(self) -> bool:
        return bool(self.listener._clients)


@pytest.fixture
def program() -> Iterator[Program]:
    program = Program()
    yield program
    program.link.close()
    program.listener.close()
    assert not program.stays


@pytest.fixture
def stranger() -> Iterator[Program]:
    program = Program("abc")
    yield program
    program.link.close()
    program.listener.close()


def test_a_program_may_fill_ten_turns_without_a_break(program: Program) -> None:
    for _ in range(10):
        assert program.turn(FULL) == []
    assert program.turn(FULL) == ["too many lines: what is read late is no longer true"]
    assert not program.stays


@pytest.mark.parametrize("pause", [b"", b"a\n"])
def test_after_a_break_it_may_fill_ten_more(program: Program, pause: bytes) -> None:
    for sent in (*[FULL] * 10, pause, *[FULL] * 10):
        assert program.turn(sent) == []
    assert program.turn(FULL) != []


def test_a_line_may_be_as_long_as_the_longest_and_no_longer(program: Program) -> None:
    assert program.turn(b"x" * LONGEST_LINE) == []
    assert program.turn(b"\n") == []
    assert program.heard == [b"x" * LONGEST_LINE]
    program.turn(b"y" * LONGEST_LINE)
    program.turn(b"y")
    assert program.heard[1:] == [b"y" * (LONGEST_LINE + 1)]
    assert not program.stays


def test_empty_lines_are_no_lines(program: Program) -> None:
    assert program.turn(b"\n \r\none\n\ntwo\n") == []
    assert program.heard == [b"one", b"two"]


def test_a_refused_line_is_answered_and_the_next_one_heard(program: Program) -> None:
    assert program.turn(b"!a\nb\n") == ["no such word: !a"]
    assert program.turn(b"!c\n") == ["no such word: !c"]
    answers = [json.loads(line) for line in program.link.recv(1000).splitlines()]
    assert answers == [{"error": "no such word: !a"}, {"error": "no such word: !c"}]
    assert program.heard == [b"b"]
    assert program.stays


def test_a_program_that_reads_no_answers_is_dropped(program: Program) -> None:
    for _ in range(50):
        program.turn(b"!a\n" * 50)
        if not program.stays:
            return
    pytest.fail("it was never dropped")


def test_a_request_of_a_browser_ends_the_connection(program: Program) -> None:
    assert program.turn(b"GET / HTTP/1.1\nb\n") == ["this is not a web server"]
    assert program.heard == []
    assert not program.stays


def test_what_was_begun_is_heard_when_the_program_ends(program: Program) -> None:
    program.turn(b"one\nlast")
    program.link.close()
    assert program.listener.poll(program.take) == []
    assert program.heard == [b"one", b"last"]
    assert not program.stays


def test_a_program_with_the_token_stays_however_long_it_is_silent(stranger: Program) -> None:
    for _ in range(39):
        assert stranger.turn() == []
    assert stranger.turn(b'{"token": "abc"}\none\n') == []
    for _ in range(100):
        stranger.turn()
    assert stranger.heard == [b"one"]
    assert stranger.stays


def test_a_program_has_forty_turns_for_its_token(stranger: Program) -> None:
    for number in range(40):
        assert stranger.stays, number
        stranger.turn()
    assert not stranger.stays


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b'{"token": "abd"}', "this is not the token of this run"),
        (b'{"token": 3}', 'the first line is {"token": "…"}, with the token that the run shows'),
        (b"[]", 'expected an object such as {"token": "…"}'),
    ],
)
def test_a_program_with_another_token_is_dropped(stranger: Program, line: bytes, why: str) -> None:
    assert stranger.turn(line + b"\none\n") == [why]
    assert stranger.heard == []
    assert not stranger.stays


def test_who_closes_twice_leaves_alone_what_another_has_opened_there(tmp_path: Path) -> None:
    address = Address(path=str(tmp_path / "words"))
    one, other = Listener(address), Listener(address)
    one.open()
    one.close()
    other.open()
    one.close()
    assert Path(address.path).exists()
    other.close()
    assert not Path(address.path).exists()


def test_nobody_comes_in_while_it_is_closed() -> None:
    assert Listener(Address()).poll(lambda _: None) == []

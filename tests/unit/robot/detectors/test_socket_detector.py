from __future__ import annotations

import json
import os
import re
import socket
import stat
from collections.abc import Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from random import Random
from select import select
from typing import Any

import pytest

from pirate_sm.core.effects import Ended, Log
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import DetectorWord, Event, OutsideNumber
from pirate_sm.robot.detectors.socket_detector import (
    LONGEST_LINE,
    AcceptedLines,
    Address,
    OutsideWords,
    read_address,
)

DOCUMENT = Path(__file__).resolve().parents[4] / "docs" / "detectors.md"
ACCEPTED = AcceptedLines(("close", "in", "past"), 1.0, {"ruler": 0.3})
TOKEN = b'{"token": "abc"}\n'
STATE: Any = None
CLOSE = b'{"word": "close", "valid_for_s": 2}\n'


@pytest.fixture
def outside() -> Iterator[OutsideWords]:
    with OutsideWords(Address("127.0.0.1", 0), ACCEPTED) as companion:
        yield companion


def connect(outside: OutsideWords) -> socket.socket:
    link = socket.create_connection((outside.address.host, outside.address.port))
    link.settimeout(5.0)
    return link


def hear(outside: OutsideWords, patience: int = 10_000) -> tuple[list[Event], list[Log]]:
    """What it says of what has been sent; what is sent on the loopback is there nearly at once."""
    for _ in range(patience):
        logs = list(outside.look(STATE, 0.0))
        said = list(outside.speak(0.0))
        if said or logs:
            break
        os.sched_yield()
    return said, logs


def test_a_line_says_a_word(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(CLOSE + b'{"word": "in"}\n')
        said = [DetectorWord("close", 2.0), DetectorWord("in", 1.0)]
        assert hear(outside) == (said, [])
        assert hear(outside, 1) == ([], [])


def test_a_line_may_come_in_pieces_and_the_last_one_without_an_end(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(CLOSE[:10])
        assert hear(outside, 10) == ([], [])
        link.sendall(CLOSE[10:-1])
        assert hear(outside, 10) == ([], [])
    assert hear(outside) == ([DetectorWord("close", 2.0)], [])


def test_several_programs_are_heard(outside: OutsideWords) -> None:
    with connect(outside) as one, connect(outside) as two:
        two.sendall(b'{"word": "past"}\n')
        assert hear(outside)[0] == [DetectorWord("past", 1.0)]
        one.sendall(CLOSE)
        assert hear(outside)[0] == [DetectorWord("close", 2.0)]


def test_a_line_that_says_nothing_is_answered_and_shown(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(b'{"word": "clos"}\nrubbish\n' + CLOSE)
        said, logs = hear(outside)
        answers = link.makefile("rb")
        first, second = json.loads(answers.readline()), json.loads(answers.readline())
        answers.close()
    assert said == [DetectorWord("close", 2.0)]
    assert first == {"error": "unknown word 'clos': did you mean 'close'?"}
    assert "not a line of JSON" in second["error"]
    assert logs == [
        Log("warning", f"from the detector's socket: {first['error']} (and 1 more)"),
    ]


def test_a_line_without_end_ends_the_connection(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(b"x" * (LONGEST_LINE + 1))
        assert hear(outside)[0] == []
        assert "at most 4096 bytes" in json.loads(link.recv(1000))["error"]
        assert link.recv(1000) == b""


def test_a_web_page_cannot_say_a_word(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(b"POST / HTTP/1.1\r\nHost: x\r\n\r\n" + CLOSE)
        assert hear(outside)[0] == []


def test_more_than_sixteen_are_turned_away(outside: OutsideWords) -> None:
    links = [connect(outside) for _ in range(17)]
    _, logs = hear(outside)
    assert "16 programs are connected already" in logs[0].message
    assert b"16 programs are connected already" in links[16].recv(100)
    assert links[16].recv(10) == b""
    links[15].sendall(CLOSE)
    assert hear(outside)[0] == [DetectorWord("close", 2.0)]
    for link in links:
        link.close()


def test_nobody_is_connected_afterwards(outside: OutsideWords) -> None:
    with connect(outside) as link:
        hear(outside, 10)
        outside.__exit__()
        assert link.recv(10) == b""
    with pytest.raises(ConnectionRefusedError):
        connect(outside)


def test_it_listens_until_the_run_ends(outside: OutsideWords) -> None:
    outside.react((Log("info", "x"),), 1.0)
    assert (outside.listening, outside.due_s) == (True, 0.0)
    outside.speak(1.0)
    assert outside.due_s == pytest.approx(1.05)
    outside.react((Log("info", "x"), Ended("succeeded", "done")), 1.0)
    assert (outside.listening, outside.due_s) == (False, inf)


def test_a_unix_socket_is_the_users_own_and_gone_afterwards(tmp_path: Path) -> None:
    path = tmp_path / "words"
    with OutsideWords(Address(path=str(path)), ACCEPTED) as companion:
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        with socket.socket(socket.AF_UNIX) as link:
            link.connect(str(path))
            link.sendall(CLOSE)
            assert hear(companion)[0] == [DetectorWord("close", 2.0)]
        with pytest.raises(UsageError, match="a run or another program listens here already"):
            OutsideWords(Address(path=str(path)), ACCEPTED).__enter__()
        assert path.exists()
    assert not path.exists()


def test_a_socket_that_a_dead_run_left_is_replaced_and_a_file_is_not(tmp_path: Path) -> None:
    left, file = tmp_path / "left", tmp_path / "file"
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(left))
    file.write_text("keep me", "utf-8")
    with OutsideWords(Address(path=str(left)), ACCEPTED):
        pass
    with pytest.raises(UsageError, match="this is not a socket, so it is left alone"):
        OutsideWords(Address(path=str(file)), ACCEPTED).__enter__()
    assert file.read_text("utf-8") == "keep me"


@pytest.mark.parametrize(
    ("path", "why"),
    [
        ("missing/words", r"missing/words: No such file or directory$"),
        ("w" * 200, r"AF_UNIX path too long$"),
    ],
)
def test_why_a_socket_cannot_be_made_is_said(tmp_path: Path, path: str, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        OutsideWords(Address(path=str(tmp_path / path)), ACCEPTED).__enter__()


def test_programs_may_come_by_the_newer_protocol_of_this_machine() -> None:
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError as error:
        pytest.skip(f"this machine has no ::1: {error}")
    with OutsideWords(Address("::1", 0), ACCEPTED) as companion, connect(companion) as link:
        link.sendall(CLOSE)
        assert hear(companion)[0] == [DetectorWord("close", 2.0)]
        assert companion.address.host == "::1"


def test_a_port_in_use_is_reported(outside: OutsideWords) -> None:
    with pytest.raises(
        UsageError, match=f"socket:127.0.0.1:{outside.address.port}: .*listens here"
    ):
        OutsideWords(outside.address, ACCEPTED).__enter__()


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("127.0.0.1:5005", Address("127.0.0.1", 5005)),
        ("localhost:80", Address("127.0.0.1", 80)),
        ("127.0.0.1:1", Address("127.0.0.1", 1)),
        ("127.0.0.1:65535", Address("127.0.0.1", 65535)),
        ("[::1]:5005", Address("::1", 5005)),
        ("/tmp/words", Address(path="/tmp/words")),
    ],
)
def test_an_address_is_read(text: str, address: Address) -> None:
    assert read_address(text) == address
    assert read_address(str(address)) == address


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("5005", "expected socket:HOST:PORT"),
        ("127.0.0.1", "expected socket:HOST:PORT"),
        ("127.0.0.1:0", "expected socket:HOST:PORT"),
        ("127.0.0.1:65536", "expected socket:HOST:PORT"),
        ("127.0.0.1:five", "expected socket:HOST:PORT"),
        ("127.0.0.1:", "expected socket:HOST:PORT"),
        ("127.0.0.1:-5", "expected socket:HOST:PORT"),
        ("127.0.0.1:\u0661", "expected socket:HOST:PORT"),
        ("127.0.0.1:0000065536", "expected socket:HOST:PORT"),
        ("127.0.0.1:" + "9" * 5000, "expected socket:HOST:PORT"),
        ("example.org:5005", "expected socket:HOST:PORT"),
        ("0.0.0.0:5005", "could steer the robot"),
        ("192.168.0.2:5005", "could steer the robot"),
        ("[::]:5005", "could steer the robot"),
    ],
)
def test_an_address_that_others_reach_or_that_is_none_is_refused(text: str, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        read_address(text)


def test_the_documented_example_says_its_word(guarded: OutsideWords) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text("utf-8"), re.DOTALL)
    assert len(example.splitlines()) <= 12
    assert '("127.0.0.1", 5005)' in example
    example = example.replace("5005", str(guarded.address.port))
    example = example.replace("the token that the run shows", "abc")

    exec(compile(example, str(DOCUMENT), "exec"), {})

    assert hear(guarded) == ([DetectorWord("close", 1.0)], [])


def test_numbers_come_through_the_same_door(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(b'{"signal": "ruler", "value": 0.05, "age_s": 0.1}\n' + CLOSE)
        said = [OutsideNumber("ruler", 0.05, 0.1), DetectorWord("close", 2.0)]
        assert hear(outside) == (said, [])


@pytest.fixture
def guarded() -> Iterator[OutsideWords]:
    with OutsideWords(Address("127.0.0.1", 0), ACCEPTED, "abc") as companion:
        yield companion


def test_a_program_with_the_token_is_heard(guarded: OutsideWords) -> None:
    with connect(guarded) as link:
        link.sendall(TOKEN + CLOSE)
        assert hear(guarded) == ([DetectorWord("close", 2.0)], [])


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (CLOSE, "the first line is"),
        (b'{"token": "abd"}\n', "not the token of this run"),
        (b'{"token": ""}\n', "not the token of this run"),
        (b'{"token": 3}\n', "the first line is"),
        (b"abc\n", "not a line of JSON"),
        (b'{"token": "\xc3\xa4"}\n', "not the token of this run"),
    ],
)
def test_a_program_without_the_token_is_disconnected(
    guarded: OutsideWords, line: bytes, why: str
) -> None:
    with connect(guarded) as link:
        link.sendall(line + CLOSE)
        said, logs = hear(guarded)
        assert said == []
        assert why in logs[0].message
        assert why in json.loads(link.recv(1000))["error"]
        assert hear(guarded, 10)[0] == []


def test_programs_that_say_nothing_do_not_keep_out_one_with_the_token(
    guarded: OutsideWords,
) -> None:
    silent = []
    for _ in range(200):
        silent.append(connect(guarded))
        hear(guarded, 1)
    with connect(guarded) as link:
        link.sendall(TOKEN + CLOSE)
        assert hear(guarded)[0] == [DetectorWord("close", 2.0)]
    for each in silent:
        each.close()


def test_a_program_that_never_gives_the_token_is_dropped(guarded: OutsideWords) -> None:
    with connect(guarded) as link:
        hear(guarded, 50)
        assert link.recv(10) == b""


def test_a_program_that_floods_is_dropped_and_others_are_heard(outside: OutsideWords) -> None:
    with connect(outside) as flood, connect(outside) as other:
        flood.setblocking(False)
        for _ in range(10_000):
            try:
                flood.send(CLOSE * 2000)
            except BlockingIOError:
                pass
            except OSError:
                break
            said, _ = hear(outside, 1)
            assert len(said) <= LONGEST_LINE // len(CLOSE) + 1
        else:
            pytest.fail("it was never dropped")
        other.sendall(b'{"word": "past"}\n')
        heard: list[Event] = []
        while DetectorWord("past", 1.0) not in heard:
            heard += hear(outside)[0]


def test_refused_lines_are_shown_at_most_once_a_second(outside: OutsideWords) -> None:
    with connect(outside) as link:
        link.sendall(b"rubbish\n")
        (log,) = hear(outside)[1]
        assert log.message.endswith("not a line of JSON in UTF-8: rubbish")
        answers = link.makefile("rb")
        answers.readline()
        for _ in range(3):
            link.sendall(b"rubbish\n")
            while not select([link], [], [], 0)[0]:
                assert outside.look(STATE, 0.9) == ()
            answers.readline()
        link.sendall(b"rubbish\n")
        logs: list[Log] = []
        while not logs:
            logs += outside.look(STATE, 1.0)
        answers.close()
    assert logs[0].message.endswith("(and 3 more)")


def test_the_usual_address_is_the_users_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert read_address("") == Address(path=str(tmp_path / "pirate_sm.detector"))
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    with pytest.raises(UsageError, match="socket:/PATH"):
        read_address("")


def test_a_million_random_bytes_say_no_word(outside: OutsideWords) -> None:
    chance, sent = Random(1), 0
    while sent < 1_000_000:
        with connect(outside) as link:
            link.settimeout(0.0)
            while sent < 1_000_000:
                try:
                    sent += link.send(chance.randbytes(2 * LONGEST_LINE))
                except OSError:  # it has been dropped, or does not read its answers
                    break
                assert hear(outside, 1)[0] == []
    with connect(outside) as honest:
        honest.sendall(CLOSE)
        assert hear(outside)[0] == [DetectorWord("close", 2.0)]


def test_two_hundred_that_flood_stall_and_lie_say_no_word(guarded: OutsideWords) -> None:
    sends = (CLOSE * 200, b"", b'{"token": "abd"}\n' + CLOSE, TOKEN[:-3], b"\xff" * LONGEST_LINE)
    crowd: list[socket.socket] = []
    for number in range(200):
        crowd.append(connect(guarded))
        with suppress(OSError):
            crowd[-1].sendall(sends[number % len(sends)])
        assert hear(guarded, 1)[0] == []

    with connect(guarded) as honest:
        honest.sendall(TOKEN + CLOSE)
        assert hear(guarded)[0] == [DetectorWord("close", 2.0)]
    for each in crowd:
        each.close()

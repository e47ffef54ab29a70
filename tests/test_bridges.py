"""The bridges in the documents do what they say: a line that comes in goes out to the run."""

from __future__ import annotations

import io
import runpy
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

BRIDGES = Path(__file__).resolve().parents[1] / "docs" / "bridges"
CLOSE = b'{"word": "close"}'


@pytest.fixture
def run(tmp_path: Path) -> Iterator[socket.socket]:
    """Return the socket of a run, which listens at ``run`` in the folder."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "run"))
        listening.listen()
        yield listening


def received(run: socket.socket) -> bytes:
    """Return all that the bridge has sent until it ended."""
    link, _ = run.accept()
    with link, link.makefile("rb") as lines:
        return lines.read()


def start(name: str, *arguments: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    runpy.run_path(str(BRIDGES / name), run_name="__main__")


def module(monkeypatch: pytest.MonkeyPatch, name: str, **content: Any) -> None:
    """Put a module of another package in place, which is not installed here."""
    made = ModuleType(name)
    vars(made).update(content)
    monkeypatch.setitem(sys.modules, name, made)
    parent, _, child = name.rpartition(".")
    if parent:
        monkeypatch.setattr(sys.modules[parent], child, made, raising=False)


def test_lines_of_the_standard_input_are_sent(
    run: socket.socket, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(CLOSE.decode() + "\n" + CLOSE.decode() + "\n"))

    start("send_lines.py", str(tmp_path / "run"), monkeypatch=monkeypatch)

    assert received(run) == (CLOSE + b"\n") * 2


def test_messages_of_a_topic_are_sent_and_retained_ones_are_not(
    run: socket.socket, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    subscribed: list[str] = []

    class Client:
        """As in paho-mqtt 2: the callbacks and the calls that a bridge makes."""

        def __init__(self, version: str) -> None:
            assert version == "2"

        def subscribe(self, topic: str) -> None:
            subscribed.append(topic)

        def connect(self, broker: str) -> None:
            assert broker == "broker"
            self.on_connect(self, None, None, None, None)

        def loop_forever(self) -> None:
            for payload, retain in ((b"{}", True), (CLOSE, False)):
                message = SimpleNamespace(payload=payload, retain=retain)
                self.on_message(self, None, message)

        on_connect: Any
        on_message: Any

    module(monkeypatch, "paho")
    module(monkeypatch, "paho.mqtt")
    version = SimpleNamespace(VERSION2="2")
    module(monkeypatch, "paho.mqtt.client", Client=Client, CallbackAPIVersion=version)

    start("from_mqtt.py", "broker", "detector", str(tmp_path / "run"), monkeypatch=monkeypatch)

    assert subscribed == ["detector"]
    assert received(run) == CLOSE + b"\n"


def test_texts_of_a_topic_become_words(
    run: socket.socket, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[Any] = []

    def create_subscription(kind: type, topic: str, send: Any, depth: int) -> None:
        assert (kind.__name__, topic, depth) == ("String", "/detector", 10)
        sent.append(send)

    node = SimpleNamespace(create_subscription=create_subscription)
    module(
        monkeypatch, "rclpy",
        init=lambda: None,
        create_node=lambda _name: node,
        spin=lambda _node: sent[0](SimpleNamespace(data="close")),
    )  # fmt: skip
    module(monkeypatch, "std_msgs")
    module(monkeypatch, "std_msgs.msg", String=type("String", (), {}))

    start("from_ros2.py", "/detector", str(tmp_path / "run"), monkeypatch=monkeypatch)

    assert received(run) == CLOSE + b"\n"

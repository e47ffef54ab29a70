"""What is on the disk before a command is sent."""

from __future__ import annotations

import threading
from pathlib import Path

from pirate_sm.core.effects import Log
from pirate_sm.core.events import Tick
from pirate_sm.running.recording.format.engine_topics import UNLOGGED
from pirate_sm.running.recording.read.reader import Recording, read_recording
from tests.unit.running.recording.keeping import Memory, recorder


def reading(path: Path, memory: Memory) -> Recording:
    path.write_bytes(memory.data)
    return read_recording(path)


def test_what_was_noted_is_in_the_file_when_it_is_secured(tmp_path: Path) -> None:
    memory = Memory()
    keeper = recorder(memory, real_time=True)
    keeper.start([], 0.0, ())
    keeper.take(Tick(), 1.0, (Log("info", "sent"),))

    while keeper.kept_s is None:  # a slow machine may need more than one try
        keeper.secure()
    read = reading(tmp_path / "run.mcap", memory)

    assert [step.at_s for step in read.steps()] == [0.0, 1.0]
    keeper.close()


def test_a_command_does_not_wait_for_a_slow_disk_but_the_file_says_so(tmp_path: Path) -> None:
    let_go = threading.Event()
    let_go.set()
    memory = Memory(wait=let_go.wait)
    keeper = recorder(memory, real_time=True)
    let_go.clear()
    keeper.start([], 0.0, ())

    keeper.secure()

    let_go.set()
    keeper.close()
    read = reading(tmp_path / "run.mcap", memory)
    assert [message.topic for message in read.messages(UNLOGGED.name)] == [UNLOGGED.name]
    assert len(list(read.steps())) == 1


def test_a_recording_that_has_failed_holds_up_nothing() -> None:
    keeper = recorder(Memory())
    keeper.failure = "the disk is full"

    keeper.secure()

    assert keeper.kept_s is None
    keeper.close()

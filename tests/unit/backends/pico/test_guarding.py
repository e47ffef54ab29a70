"""What the guardian decides, in virtual time."""

from __future__ import annotations

from math import inf

from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.backends.pico.framing import encode
from pirate_sm.backends.pico.guarding import (
    Action,
    Finish,
    Guard,
    Kind,
    Note,
    NoteReader,
    Reopen,
    ToPort,
    ToRunner,
)

SAFE = encode(100, b"safe array")
ECHO = encode(126, b"safe array")
STOP = encode(11)


def beating(now: float = 0.0) -> Guard:
    guard = Guard(0.3)
    guard.hear(Note(Kind.BEAT, SAFE), now)
    return guard


def until(guard: Guard, end_s: float) -> list[tuple[float, Action]]:
    done: list[tuple[float, Action]] = []
    while guard.due_s <= end_s:
        now = guard.due_s
        done += [(now, action) for action in guard.tick(now)]
    return done


@given(
    notes=st.lists(st.builds(Note, st.sampled_from(Kind), st.binary(max_size=50))),
    cut=st.integers(1, 20),
)
def test_notes_travel_in_any_pieces(notes: list[Note], cut: int) -> None:
    data = b"".join(note.to_bytes() for note in notes)
    reader = NoteReader()
    read = []
    for at in range(0, len(data), cut):
        read += reader.feed(data[at : at + cut])

    assert read == notes


def test_it_relays_both_ways() -> None:
    guard = beating()

    assert guard.hear(Note(Kind.WRITE, b"out"), 0.1) == [ToPort(b"out")]
    assert guard.receive(b"in", 0.1) == [ToRunner(Note(Kind.DATA, b"in"))]
    assert guard.hear(Note(Kind.REOPEN), 0.1) == [Reopen()]
    assert guard.hear(Note(Kind.LEAVE), 0.1) == [Finish()]


def test_a_runner_that_beats_is_left_alone() -> None:
    guard = Guard(0.3)
    for beat in range(100):
        assert until(guard, beat * 0.25) == []
        guard.hear(Note(Kind.BEAT, SAFE), beat * 0.25)


def test_a_silent_runner_is_overruled_in_time_and_told() -> None:
    done = until(beating(), 0.5)

    assert done[0] == (0.3, ToRunner(Note(Kind.OVERRULED)))
    assert done[1] == (0.3, ToPort(SAFE))


def test_it_has_nothing_to_send_before_anything_was_set_in_motion() -> None:
    guard = Guard(0.3)
    guard.hear(Note(Kind.BEAT, b""), 0.0)

    assert guard.due_s == inf
    assert guard.bereave(1.0) == [Finish()]


def test_what_a_runner_wrote_before_it_stood_still_does_not_pass_until_it_has_understood() -> None:
    guard = beating()
    until(guard, 0.5)

    assert guard.hear(Note(Kind.WRITE, b"drive"), 0.6) == []
    guard.hear(Note(Kind.HEED), 0.7)
    assert guard.hear(Note(Kind.WRITE, b"safe"), 0.7) == [ToPort(b"safe")]


def test_when_the_runner_dies_the_safe_frame_is_repeated_until_it_is_echoed() -> None:
    guard = beating()
    assert guard.bereave(0.1) == [ToPort(SAFE)]
    assert until(guard, 0.35) == [(0.2, ToPort(SAFE)), (0.30000000000000004, ToPort(SAFE))]

    assert guard.receive(ECHO, 0.36) == [ToPort(STOP), Finish()]
    assert until(guard, 10.0) == []


def test_without_an_echo_it_gives_up_after_a_few_seconds() -> None:
    guard = beating()
    guard.bereave(0.0)
    done = [action for _, action in until(guard, 10.0)]

    assert 5 < done.count(ToPort(SAFE)) < 50
    assert done[-1] == Finish()


def test_the_safe_frame_waits_until_the_ring_of_the_device_has_room() -> None:
    guard = beating()
    guard.hear(Note(Kind.WRITE, bytes(48)), 0.1)

    assert guard.bereave(0.11) == []
    assert until(guard, 0.2)[0] == (0.13, ToPort(SAFE))


def test_the_echo_of_something_else_does_not_stop_it() -> None:
    guard = beating()
    guard.bereave(0.0)

    assert guard.receive(encode(126, b"drive array"), 0.05) == []
    assert guard.acting


def test_a_runner_that_dies_after_it_was_overruled_leaves_a_robot_that_is_safe_already() -> None:
    guard = beating()
    until(guard, 0.31)
    guard.receive(ECHO, 0.35)

    assert guard.bereave(1.0) == [ToPort(STOP), Finish()]

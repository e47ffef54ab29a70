"""What the guardian decides, in virtual time."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import pytest

from pirate_sm.robot.backends.serial.guardian.guard import (
    AFTER_A_WRITE_S,
    REOPEN_EVERY_S,
    Action,
    EndGuardian,
    Guard,
    Instructions,
    Note,
    NoteKind,
    Reopen,
    ToPort,
    ToRunner,
)
from pirate_sm.robot.rosserial.frames import FIRST_OF_THE_DEVICE, Decoder, SerialFrame, encode
from pirate_sm.simulation.bay.node_handle import NodeHandle

from ..bench import ARRAY, ECHO, FIRST_PUBLISHER, FIRST_SUBSCRIBER, STATE, WANTED, topic

SAFE = encode(FIRST_SUBSCRIBER, b"safe array")
DRIVE = encode(FIRST_SUBSCRIBER, b"drive array")
ECHOED = encode(FIRST_PUBLISHER, b"safe array")
HEARD, STOPPED = ToRunner(Note(NoteKind.HEARD)), ToRunner(Note(NoteKind.STOPPED))
OVERRULED = ToRunner(Note(NoteKind.OVERRULED))
STOP, ASK = encode(11), encode(0)
BOOT_S, STAY_S = 2.0, 60.0
EPOCH_S = 1000.0


def beating(now: float = 0.0) -> Guard:
    """A guard whose runner has driven the robot."""
    guard = Guard(Instructions(0.3, WANTED, BOOT_S, STAY_S), EPOCH_S)
    guard.opened(now - 10.0)
    guard.hear(Note(NoteKind.WRITE, DRIVE), now - 1.0)
    guard.hear(Note(NoteKind.BEAT, SAFE), now)
    return guard


def until(guard: Guard, end_s: float) -> list[tuple[float, Action]]:
    done: list[tuple[float, Action]] = []
    while guard.due_s <= end_s and not any(isinstance(each, EndGuardian) for _, each in done[-2:]):
        now = guard.due_s
        done += [(now, action) for action in guard.tick(now)]
    return done


def written(done: list[tuple[float, Action]]) -> list[tuple[float, bytes]]:
    return [(round(at_s, 6), each.data) for at_s, each in done if isinstance(each, ToPort)]


def introductions(shift: int) -> bytes:
    """What a device that was reset answers, its topics numbered anew."""
    publishers = topic(FIRST_PUBLISHER + shift, ECHO), topic(FIRST_PUBLISHER + shift + 1, STATE)
    node = NodeHandle(publishers, (topic(FIRST_SUBSCRIBER + shift, ARRAY),))
    says = node.take(SerialFrame(0, b""), 0.0).says
    return b"".join(encode(*frame) for frame in says)


def test_it_relays_both_ways() -> None:
    guard = beating()

    assert guard.hear(Note(NoteKind.WRITE, b"out"), 0.1) == [ToPort(b"out")]
    assert guard.receive(b"in", 0.1) == [ToRunner(Note(NoteKind.DATA, b"in"))]
    assert guard.hear(Note(NoteKind.BEAT, SAFE), 0.1) == [HEARD]
    assert guard.hear(Note(NoteKind.LEAVE), 0.1) == [EndGuardian()]


def test_no_stop_is_confirmed_before_the_guardian_has_taken_over() -> None:
    assert not beating().confirmed


def test_a_runner_that_beats_is_left_alone() -> None:
    guard = beating()
    for beat in range(100):
        assert until(guard, beat * 0.25) == []
        guard.hear(Note(NoteKind.BEAT, SAFE), beat * 0.25)


def test_a_silent_runner_is_overruled_in_time_and_told() -> None:
    done = until(beating(), 0.31)

    assert [(round(at_s, 6), each) for at_s, each in done] == [
        (0.3, OVERRULED),
        (0.3, ToPort(SAFE)),
    ]


def test_one_more_beat_is_allowed_when_the_guardian_itself_stood_still() -> None:
    guard = beating()
    assert until(guard, 0.2) == []
    assert guard.tick(3.0) == []  # its wait came back much later than it asked for
    assert until(guard, 3.25) == []
    guard.hear(Note(NoteKind.BEAT, SAFE), 3.26)
    assert until(guard, 3.5) == []

    assert OVERRULED in [each for _, each in until(guard, 3.6)]


def test_it_has_nothing_to_send_before_anything_was_set_in_motion() -> None:
    guard = Guard(Instructions(0.3, WANTED), EPOCH_S)
    guard.opened(0.0)
    guard.hear(Note(NoteKind.BEAT, b""), 0.0)

    assert guard.due_s == inf
    assert guard.runner_gone(1.0) == [EndGuardian()]


def test_what_a_runner_wrote_before_it_stood_still_does_not_pass_until_it_has_understood() -> None:
    guard = beating()
    until(guard, 0.5)

    assert guard.hear(Note(NoteKind.WRITE, DRIVE), 0.6) == []
    guard.hear(Note(NoteKind.HEED), 0.7)
    assert guard.hear(Note(NoteKind.WRITE, SAFE), 0.7) == [ToPort(SAFE)]


def test_when_the_runner_dies_the_safe_frame_is_repeated_until_it_is_echoed() -> None:
    guard = beating()
    assert guard.runner_gone(0.1) == [ToPort(SAFE)]
    assert written(until(guard, 0.35)) == [(0.2, SAFE), (0.3, SAFE)]

    assert guard.receive(ECHOED, 0.36) == [ToPort(STOP), EndGuardian()]


def test_bytes_that_a_talking_device_says_end_nothing() -> None:
    guard = beating()
    guard.runner_gone(0.1)

    assert guard.receive(encode(FIRST_PUBLISHER + 1, b"a state"), 0.2) == []
    assert guard.receive(b"a", 0.2) == []
    assert guard.receive(encode(FIRST_PUBLISHER, b"drive array"), 0.2) == []
    assert guard.acting


def test_an_unconfirmed_stop_is_tried_for_as_long_as_it_was_told_and_no_longer() -> None:
    guard = beating()
    done = [(0.0, each) for each in guard.runner_gone(0.0)] + until(guard, 2 * STAY_S)
    safe_s = [at_s for at_s, data in written(done) if data == SAFE]

    assert done[-1] == (STAY_S, EndGuardian(stopped=False))
    assert max(b - a for a, b in zip(safe_s, [*safe_s[1:], STAY_S], strict=True)) < 0.15


def test_a_runner_that_leaves_while_the_stop_is_unconfirmed_dismisses_nobody() -> None:
    guard = beating()
    until(guard, 0.31)

    assert not any(isinstance(each, EndGuardian) for each in guard.hear(Note(NoteKind.LEAVE), 0.4))
    assert EndGuardian() in guard.receive(ECHOED, 0.5)


def test_the_safe_frame_waits_until_the_ring_of_the_device_has_room() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, bytes(48)), 0.1)

    assert guard.runner_gone(0.11) == []
    assert written(until(guard, 0.2))[0] == (0.13, SAFE)


def test_a_late_echo_of_what_the_runner_wrote_itself_confirms_nothing() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, SAFE), 0.0)
    guard.hear(Note(NoteKind.WRITE, DRIVE), 0.05)
    guard.runner_gone(0.06)
    until(guard, 0.1)

    assert guard.receive(ECHOED, 0.12) == []
    until(guard, 0.4)
    assert EndGuardian() in guard.receive(ECHOED, 0.4)


def test_a_port_that_comes_back_to_no_runner_is_opened_and_asked_for_its_new_numbers() -> None:
    guard = beating()
    assert guard.lost("unplugged", 0.1) == [ToRunner(Note(NoteKind.LOST, b"unplugged"))]
    assert guard.runner_gone(0.2) == []
    done = until(guard, 9.0)
    assert {each for _, each in done} == {Reopen()}
    assert done[1][0] - done[0][0] == pytest.approx(REOPEN_EVERY_S)

    guard.opened(9.0)
    assert until(guard, 9.0 + BOOT_S - 0.01) == []  # the boot loader listens
    asked = written(until(guard, 9.0 + BOOT_S + 0.35))
    assert {data for _, data in asked} == {ASK}, "no number is known on this connection"

    guard.receive(introductions(7) * 2, 11.4)
    (_, data), *_ = written(until(guard, 11.5))
    assert Decoder().feed(data) == [(FIRST_SUBSCRIBER + 7, b"safe array")]
    echo = encode(FIRST_PUBLISHER + 7, b"safe array")
    assert guard.receive(echo, 11.6) == [ToPort(STOP), EndGuardian()]


def test_numbers_that_were_learnt_before_the_port_went_away_again_are_not_used_after() -> None:
    guard = beating()
    guard.runner_gone(0.0)
    guard.receive(introductions(7) * 2, 0.1)
    guard.lost("unplugged", 0.2)
    guard.opened(5.0)

    assert until(guard, 5.0 + BOOT_S - 0.01) == []
    assert {data for _, data in written(until(guard, 9.0))} == {ASK}


def test_a_device_that_was_reset_in_between_is_asked_while_the_old_number_goes_on() -> None:
    guard = beating()
    guard.runner_gone(0.0)
    data = {data for _, data in written(until(guard, 1.0))}

    assert data == {SAFE, ASK}


def test_a_port_that_cannot_be_opened_at_first_is_tried_again() -> None:
    guard = Guard(Instructions(0.3, WANTED, BOOT_S), EPOCH_S)
    guard.hear(Note(NoteKind.BEAT, SAFE), 0.0)
    assert guard.refused("not there", 0.0) == [ToRunner(Note(NoteKind.REFUSED, b"not there"))]
    guard.runner_gone(0.1)

    assert until(guard, 0.6) == [(0.5, Reopen())]


def test_the_stop_that_an_earlier_run_left_undone_comes_before_anything_of_the_new_one() -> None:
    guard = Guard(Instructions(0.3, WANTED, BOOT_S), EPOCH_S)
    guard.opened(0.0)
    guard.hear(Note(NoteKind.STOP, b"safe array"), 0.0)
    assert guard.hear(Note(NoteKind.WRITE, DRIVE), 0.1) == []
    until(guard, BOOT_S)
    guard.receive(introductions(0) * 2, BOOT_S)
    assert written(until(guard, BOOT_S + 0.05))[-1][1] == SAFE

    assert STOPPED in guard.receive(ECHOED, BOOT_S + 0.1)
    guard.hear(Note(NoteKind.HEED), BOOT_S + 0.2)
    assert guard.hear(Note(NoteKind.WRITE, DRIVE), BOOT_S + 0.3) == [ToPort(DRIVE)]


def test_a_runner_that_dies_after_it_was_overruled_leaves_a_robot_that_is_safe_already() -> None:
    guard = beating()
    until(guard, 0.31)
    guard.receive(ECHOED, 0.35)

    assert guard.due_s == inf
    assert guard.tick(0.9) == []
    assert guard.runner_gone(1.0) == [ToPort(STOP), EndGuardian()]


def test_a_confirmed_stop_counts_no_more_once_the_runner_drives_again() -> None:
    guard = beating()
    until(guard, 0.31)
    guard.receive(ECHOED, 0.35)
    guard.hear(Note(NoteKind.HEED), 0.4)
    guard.hear(Note(NoteKind.WRITE, DRIVE), 0.5)

    assert guard.runner_gone(1.0) == [ToPort(SAFE)]


def overruled(now: float = 0.31) -> Guard:
    """A guard whose runner has fallen silent, and that has written the safe array itself."""
    guard = beating()
    assert written(until(guard, now)) == [(0.3, SAFE)]
    return guard


def test_it_looks_six_times_within_the_time_after_which_a_runner_is_silent() -> None:
    assert beating().due_s == pytest.approx(0.3 / 6)


def test_a_guard_that_has_heard_nothing_yet_has_nothing_to_do() -> None:
    assert Guard(Instructions(0.3, WANTED), EPOCH_S).due_s == inf


def test_while_nothing_was_set_in_motion_a_silent_runner_is_left_alone() -> None:
    guard = Guard(Instructions(0.3, WANTED), EPOCH_S)
    guard.opened(0.0)
    guard.hear(Note(NoteKind.BEAT, b""), 0.0)

    assert [guard.tick(look / 20) for look in range(20)] == [[]] * 20
    assert not guard.acting


def test_a_runner_that_leaves_a_stopped_robot_ends_the_guardian() -> None:
    guard = overruled()
    guard.receive(ECHOED, 0.35)

    assert guard.hear(Note(NoteKind.LEAVE), 0.4) == [EndGuardian()]


def test_what_a_late_beat_says_does_not_replace_the_array_that_stops_the_robot() -> None:
    guard = overruled()

    assert guard.hear(Note(NoteKind.BEAT, DRIVE), 0.32) == [HEARD]
    assert written(until(guard, 0.4)) == [(0.4, SAFE)]


def test_each_beat_says_what_would_stop_the_robot_now() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.BEAT, encode(FIRST_SUBSCRIBER, b"another")), 0.05)

    assert guard.runner_gone(0.1) == [ToPort(encode(FIRST_SUBSCRIBER, b"another"))]


@pytest.mark.parametrize("data", [encode(10, b"12345678"), b"no frame", b""])
def test_other_frames_of_the_runner_do_not_change_the_number_of_its_topic(data: bytes) -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, data), 0.0)

    assert guard.runner_gone(0.1) == [ToPort(SAFE)]


def test_where_the_runner_wrote_another_array_the_first_echo_confirms_the_stop() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, DRIVE), 0.05)
    assert guard.runner_gone(0.09) == [ToPort(SAFE)]

    assert EndGuardian() in guard.receive(ECHOED, 0.12)


def test_an_echo_before_anything_was_written_confirms_nothing() -> None:
    guard = Guard(Instructions(0.3, WANTED, BOOT_S), EPOCH_S)
    guard.opened(0.0)
    guard.hear(Note(NoteKind.STOP, b"safe array"), 0.0)

    assert guard.receive(ECHOED, 0.5) == [ToRunner(Note(NoteKind.DATA, ECHOED))]
    assert not guard.confirmed


def test_the_echo_of_a_runner_that_is_heeded_again_confirms_no_stop() -> None:
    guard = overruled()
    guard.hear(Note(NoteKind.HEED), 0.4)

    assert guard.receive(ECHOED, 1.0) == [ToRunner(Note(NoteKind.DATA, ECHOED))]
    assert not guard.confirmed


def test_a_stop_is_confirmed_once() -> None:
    guard = overruled()

    assert guard.receive(ECHOED, 0.35) == [ToRunner(Note(NoteKind.DATA, ECHOED)), STOPPED]
    assert guard.receive(ECHOED, 0.4) == [ToRunner(Note(NoteKind.DATA, ECHOED))]


@pytest.mark.parametrize(
    ("number", "confirms"),
    [
        (FIRST_OF_THE_DEVICE - 1, False),
        (FIRST_SUBSCRIBER, False),
        (FIRST_PUBLISHER, True),
    ],
)
def test_only_topics_of_the_device_that_nobody_writes_are_echoes(
    number: int, confirms: bool
) -> None:
    guard = overruled()

    guard.receive(encode(number, b"safe array"), 0.35)

    assert guard.confirmed == confirms


@pytest.mark.parametrize(("at_s", "confirms"), [(0.6, False), (0.61, True)])
def test_the_echo_of_the_runners_own_safe_array_may_be_late(at_s: float, confirms: bool) -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, SAFE), 0.3)
    guard.runner_gone(0.31)
    until(guard, 0.4)

    guard.receive(ECHOED, at_s)

    assert guard.confirmed == confirms


def test_the_first_topic_of_a_device_may_be_its_echo() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.WRITE, encode(FIRST_OF_THE_DEVICE + 1, b"drive array")), 0.0)
    until(guard, 0.31)

    guard.receive(encode(FIRST_OF_THE_DEVICE, b"safe array"), 0.35)

    assert guard.confirmed


def test_what_was_written_before_a_runner_was_heeded_confirms_no_later_stop() -> None:
    guard = overruled()
    guard.receive(ECHOED, 0.35)
    guard.hear(Note(NoteKind.HEED), 0.4)
    guard.hear(Note(NoteKind.WRITE, DRIVE), 1.0)
    assert guard.runner_gone(1.01) == [], "the ring of the device has no room yet"

    guard.receive(ECHOED, 1.02)

    assert not guard.confirmed


def test_half_a_frame_of_before_the_port_went_away_hides_no_echo_after_it() -> None:
    guard = beating()
    guard.runner_gone(0.1)
    guard.receive(ECHOED[:-4], 0.2)
    guard.lost("unplugged", 0.3)
    guard.opened(1.0)
    until(guard, 1.0 + BOOT_S)
    guard.receive(introductions(0) * 2, 1.0 + BOOT_S)
    until(guard, 1.5 + BOOT_S)

    guard.receive(ECHOED, 1.5 + BOOT_S)

    assert guard.confirmed


def test_half_a_frame_that_the_runner_was_given_hides_no_echo() -> None:
    guard = beating()
    guard.hear(Note(NoteKind.STOP, b"safe array"), 0.1)
    until(guard, 0.15)
    guard.receive(ECHOED[:-4], 0.16)
    guard.hear(Note(NoteKind.STOP, b"safe array"), 0.2)
    until(guard, 0.25)

    guard.receive(ECHOED, 0.26)

    assert guard.confirmed


def test_a_device_that_has_booted_long_ago_is_asked_at_once_where_no_number_is_known() -> None:
    guard = Guard(Instructions(0.3, WANTED, BOOT_S), EPOCH_S)
    guard.opened(0.0)
    guard.hear(Note(NoteKind.STOP, b"safe array"), 10.0)

    assert written(until(guard, 10.2))[0] == (10.0, ASK)


def test_two_frames_are_never_written_at_once() -> None:
    guard = beating()
    guard.runner_gone(0.0)
    assert guard.tick(0.04) == [], "nothing is due yet"
    written_s = [at_s for at_s, _ in written(until(guard, 3.0))]

    assert len(written_s) > 20
    assert min(b - a for a, b in pairwise(written_s)) >= AFTER_A_WRITE_S - 1e-6


def test_the_number_that_a_device_gives_its_topic_now_counts() -> None:
    guard = beating()
    guard.runner_gone(0.0)
    until(guard, 1.0)
    guard.receive(introductions(7) * 2, 1.0)

    assert written(until(guard, 1.2))[-1][1] == encode(FIRST_SUBSCRIBER + 7, b"safe array")


def test_to_a_port_that_has_gone_nothing_is_written_at_the_end() -> None:
    guard = beating()
    guard.lost("unplugged", 0.1)
    guard.runner_gone(0.2)

    done = until(guard, 2 * STAY_S)

    assert done[-1] == (0.2 + STAY_S, EndGuardian(stopped=False))
    assert written(done) == []

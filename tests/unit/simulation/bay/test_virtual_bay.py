"""What a host sees of a bay with which nothing is wrong."""

from __future__ import annotations

import math

import pytest

from pirate_sm.core.documents import read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import validate
from pirate_sm.core.models import Pipe, Profile, Serial
from pirate_sm.robot.rosserial.frames import encode
from pirate_sm.robot.rosserial.messages import Array
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.virtual import VirtualBay

from .conftest import (
    ECHO,
    ROOT,
    SETPOINTS,
    STATE,
    Host,
    MakeBay,
    array,
    read_array,
    read_profile,
    read_state,
)


def driving(number: int, duty: int = 1000) -> bytes:
    return array(number, 0, 0, 0, 0, 0, duty)


def test_it_is_silent_until_it_is_asked(make: MakeBay) -> None:
    host = make()
    host.open()

    assert host.listen(20.0) == []


def test_it_does_not_hear_what_comes_while_it_boots(make: MakeBay) -> None:
    host = make()
    host.open()
    host.listen(1.4)
    host.send(0)

    assert host.listen(1.0) == []


@pytest.mark.parametrize("seed", range(5))
def test_it_answers_between_one_and_a_half_and_two_seconds_after_opening(
    make: MakeBay, seed: int
) -> None:
    host = make(seed)
    host.open()
    answered = None
    while answered is None:
        host.send(0)
        if host.listen(0.05):
            answered = host.now_s

    assert 1.5 < answered < 2.15


def test_it_introduces_itself_in_order(make: MakeBay) -> None:
    host = make()
    host.open()
    host.listen(2.1)
    host.send(0)
    heard = host.listen(0.2)

    assert [each.topic for each in heard if each.topic != STATE] == [10, 0, 0, 1, 7]
    assert (
        bytes.fromhex(
            "fffe5a00a5010064000e000000736574706f696e745f61727261791a0000007069726174655f6d7367732f5365"
            "74706f696e745f4172726179200000003931636232313663623031666165623336626633376636383936616631"
            "6165610002000062"
        )
        in host.raw
    )
    assert bytes.fromhex("fffe0e00f1070001090000006261792072656164797d") in host.raw


def test_62_states_a_second_each_of_a_board_that_is_fitted(host: Host, profile: Profile) -> None:
    states = [read_state(each.payload) for each in host.listen(4.0) if each.topic == STATE]
    speaking = [b.id for b in profile.boards if b.fitted and b.channels_fitted]

    assert len(states) / 4.0 == pytest.approx(62.5, abs=0.5)
    boards = [board for board, _ in states]
    assert all(
        boards.count(board) == pytest.approx(250 / len(speaking), abs=1) for board in speaking
    )
    assert sorted(set(boards)) == speaking


def test_states_tell_what_the_robot_does(host: Host) -> None:
    def last(board: int, channel: int) -> float:
        found = [
            s
            for s in map(read_state, (h.payload for h in host.heard if h.topic == STATE))
            if s[0] == board
        ]
        return found[-1][1][channel]

    host.send(SETPOINTS, array(1, *(0,) * 12, 300))
    host.listen(1.0)

    turned = host.bay.truth.bends_rad[3]
    assert abs(turned) > 0.05
    assert last(26, 0) == pytest.approx(turned * 4096 / math.tau, abs=20)
    assert last(22, 0) == pytest.approx(0.0, abs=20)


def test_an_array_is_echoed_50_ms_after_it_came(host: Host) -> None:
    host.send(SETPOINTS, driving(2, 7))
    sent = host.now_s
    (echo,) = [each for each in host.listen(0.2) if each.topic == ECHO]

    (received,) = host.events("received")
    (echoed,) = host.events("echoed")
    assert read_array(echo.payload) == (2, (0, 0, 0, 0, 0, 7, *(0,) * 12))
    # 8.3 ms on the line, then the firmware looks once in 16 ms.
    assert 0.008 < received.at_s - sent < 0.008 + 0.017
    assert echoed.at_s - received.at_s == pytest.approx(0.050, abs=0.001)
    assert 0.065 < echo.at_s - sent < 0.095


def test_an_array_is_in_force_within_a_cycle(host: Host) -> None:
    host.send(SETPOINTS, driving(3, -500))
    host.listen(0.05)

    (received,) = host.events("received")
    (applied,) = host.events("applied")
    assert received.at_s < applied.at_s < received.at_s + 0.016
    assert -0.5 in host.bay.duties
    assert host.bay.last_array == host.bay.last_applied == Array(3, received.counts)


def test_setpoints_beyond_what_a_slot_takes_are_cut(host: Host) -> None:
    host.send(SETPOINTS, driving(4, 30_000))
    host.listen(0.05)

    assert max(host.bay.duties) == 1.0


def test_it_obeys_nothing_before_it_is_asked_for_its_topics(make: MakeBay) -> None:
    host = make()
    host.open()
    host.listen(2.1)
    host.send(SETPOINTS, driving(5))

    assert host.listen(0.3) == []
    assert max(host.bay.duties) == 0.0


def test_motors_go_on_when_the_link_is_lost(host: Host) -> None:
    host.send(SETPOINTS, array(6, *(0,) * 12, 300))
    host.listen(0.1)
    before = host.bay.truth.bends_rad[3]
    host.bay.close(host.now_s)

    assert host.listen(2.0) == []
    assert max(host.bay.duties) == 0.3
    assert abs(host.bay.truth.bends_rad[3] - before) > 0.1


def test_opening_the_port_resets_it_and_its_setpoints(host: Host) -> None:
    host.send(SETPOINTS, driving(7))
    host.listen(0.1)
    host.bay.close(host.now_s)
    host.open()
    host.listen(1.0)
    assert max(host.bay.duties) == 1.0  # nobody has written others yet
    host.listen(1.1)

    assert not host.bay.configured
    assert set(host.bay.duties) == {0.0}


def test_without_time_it_stops_publishing_after_11_s(host: Host) -> None:
    host.answers_time = False
    host.listen(9.0)
    assert host.bay.configured
    host.listen(2.5)

    assert not host.bay.configured
    assert host.listen(5.0) == []
    host.send(0)
    assert [h.topic for h in host.listen(0.2)] != []


def test_it_asks_for_the_time_every_two_and_a_half_seconds(host: Host) -> None:
    asked = [each.at_s for each in host.listen(20.0) if each.topic == 10]

    assert len(asked) == 8
    assert asked[1] - asked[0] == pytest.approx(2.5, abs=0.02)


def test_a_payload_that_is_too_short_is_executed_with_what_came_before(host: Host) -> None:
    host.send(SETPOINTS, array(8, *range(1, 19)))
    host.listen(0.1)
    host.send(SETPOINTS, array(9, 100, 101)[:8])
    host.listen(0.1)

    assert host.bay.last_array == Array(9, (100, 101, *range(3, 19)))


def test_an_id_that_nobody_listens_to_is_noted(host: Host) -> None:
    host.send(101, b"x")
    host.listen(0.05)

    assert [each.detail for each in host.events("fault")] == [
        "nobody listens to id 101: memory is overwritten"
    ]


def test_no_frame_is_complete_before_due_s(host: Host) -> None:
    frames = 0
    while frames < 100:
        due = host.bay.due_s
        for at in (due - 1e-6, due):
            host.now_s = max(at, host.now_s)
            came = host.take(host.bay.advance(host.now_s))
            assert at == due or came == []
            frames += len(came)


def test_equal_seeds_give_equal_bytes(make: MakeBay) -> None:
    def bytes_of(seed: int) -> bytes:
        host = make(
            seed,
            loss_in=0.2,
            loss_out=0.2,
            corruption=0.01,
            jitter_s=0.005,
            reset_every_s=3.0,
            spontaneous_every_s=2.0,
            stale_every_s=1.0,
            defects=("gamma_3_spikes",),
        )
        host.open()
        for number in range(100):
            if number % 10 == 0:
                host.send(0)
            host.send(SETPOINTS, driving(number, number))
            host.listen(0.1)
        return host.raw

    assert bytes_of(4) == bytes_of(4)
    assert bytes_of(4) != bytes_of(5)


def test_one_value_at_a_time(profile: Profile, texts: dict[str, str], pipe: Pipe) -> None:
    assert profile.serial is not None
    state = profile.serial.state.model_copy(update={"layout": "value"})
    serial = profile.serial.model_copy(update={"state": state})
    one_value = profile.model_copy(update={"serial": serial})
    own = {**texts, state.type: "uint8 board\nuint8 channel\nfloat32 value"}
    host = Host(VirtualBay(one_value, pipe, own))
    host.connect()
    states = [each.payload for each in host.listen(2.0) if each.topic == STATE]

    assert {len(payload) for payload in states} == {6}
    pairs = [(payload[0], payload[1]) for payload in states]
    everything = [
        (board.id, channel)
        for board in profile.boards
        if board.fitted and board.channels_fitted
        for channel in range(len(board.channels))
    ]
    start = everything.index(pairs[0])
    turns = everything[start:] + everything[:start]
    assert pairs == [turns[i % len(turns)] for i in range(len(pairs))]


def other() -> Profile:
    newt = read_profile(ROOT / "tests" / "robots" / "newt" / "profile.yaml")
    serial = {
        "baud": 115200,
        "boot": "1 s",
        "echo_within": "100 ms",
        "heartbeat_within": "1 s",
        "setpoints": {"topic": "go", "type": "newt/Go", "id": "number", "values": "to"},
        "echo": {"topic": "went", "type": "newt/Go", "id": "number", "values": "to"},
        "state": {"topic": "is", "type": "newt/Is", "layout": "board"},
    }
    return newt.model_copy(update={"serial": Serial.model_validate(serial)})


TEXTS = {"newt/Go": "uint32 number\nint16[] to", "newt/Is": "uint8 board\nint32[] values"}
ELBOW = ROOT / "tests" / "robots" / "newt" / "elbow.yaml"


def elbow() -> Pipe:
    return validate(read_document(ELBOW), Pipe)


def test_any_robot_with_a_serial_link_can_be_emulated() -> None:
    host = Host(VirtualBay(other(), elbow(), TEXTS))
    host.connect()
    slots = len(other().slots)
    payload = (1).to_bytes(4, "little") + slots.to_bytes(4, "little") + b"\x64\0" * slots
    host.send(SETPOINTS, payload)
    heard = host.listen(0.5)

    assert [each.payload for each in heard if each.topic == ECHO] == [payload]
    assert {each.payload[0] for each in heard if each.topic == STATE} == {40, 3, 17}
    assert max(host.bay.duties) == 0.5


def test_what_does_not_fit_together_is_refused(
    profile: Profile, texts: dict[str, str], pipe: Pipe
) -> None:
    bare = profile.model_copy(update={"serial": None})
    with pytest.raises(UsageError, match="no section 'serial'"):
        VirtualBay(bare, pipe, texts)
    with pytest.raises(UsageError, match=r"Is\.msg is missing: put the text"):
        VirtualBay(other(), elbow(), {"newt/Go": TEXTS["newt/Go"]})
    with pytest.raises(UsageError, match="'to' must be 7 integers, one for each slot"):
        VirtualBay(other(), elbow(), {**TEXTS, "newt/Go": "uint32 number\nint16[5] to"})
    with pytest.raises(UsageError, match="has room for 1 values, and a board has"):
        VirtualBay(other(), elbow(), {**TEXTS, "newt/Is": "uint8 board\nint32[1] values"})
    with pytest.raises(UsageError, match="there is no defect 'nonsense'"):
        VirtualBay(profile, pipe, texts, Switches(defects=("nonsense",)))


def test_the_captured_array_gives_the_captured_echo(host: Host) -> None:
    body = "00020000000100ffff000000000000000000000000000000000000000000000000000000000000e903"
    sent = bytes.fromhex(f"fffe2800d764{body}ae")
    assert encode(SETPOINTS, sent[7:-1]) == sent
    host.bay.receive(sent, host.now_s)
    host.listen(0.2)

    assert bytes.fromhex(f"fffe2800d77e{body}94") in host.raw

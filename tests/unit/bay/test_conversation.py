from __future__ import annotations

from pirate_sm.bay.conversation import Answer, Conversation, Topic, log_message, topic_info
from pirate_sm.bay.frames import Frame, encode

SAYS = Topic(125, "state", "pirate_msgs/State", "704cdcb7b128fe0240339af8c705abae")
HEARS = Topic(
    100, "setpoint_array", "pirate_msgs/Setpoint_Array", "91cb216cb01faeb36bf37f6896af1aea"
)


def talk() -> Conversation:
    return Conversation([SAYS], [HEARS])


def frame(topic: int, payload: bytes = b"") -> Frame:
    return Frame(topic, payload, len(payload))


def test_topics_are_announced_as_captured() -> None:
    assert encode(0, topic_info(SAYS)).hex() == (
        "fffe4800b700007d00050000007374617465110000007069726174655f6d7367732f5374617465200000003730"
        "3463646362376231323866653032343033333961663863373035616261650002000049"
    )
    assert encode(1, topic_info(HEARS)).hex() == (
        "fffe5a00a5010064000e000000736574706f696e745f61727261791a0000007069726174655f6d7367732f5365"
        "74706f696e745f4172726179200000003931636232313663623031666165623336626633376636383936616631"
        "616561" + "0002000062"
    )


def test_a_log_line_is_said_as_captured() -> None:
    assert encode(*log_message("bay ready")).hex() == (
        "fffe0e00f1070001090000006261792072656164797d"
    )


def test_it_asks_the_time_then_names_publishers_then_subscribers() -> None:
    says = talk().take(frame(0), 1.0).says

    assert [message.topic for message in says] == [10, 0, 1]
    assert says[0].payload == bytes(8)


def test_it_says_nothing_by_itself_before_it_is_asked() -> None:
    it = talk()

    assert [it.tick(float(now)) for now in range(60)] == [()] * 60
    assert not it.configured


def test_it_asks_the_time_every_two_and_a_half_seconds() -> None:
    it = talk()
    it.take(frame(0), 0.0)
    asked = []
    for tick in range(2000):
        now = tick / 100
        if it.tick(now):
            asked.append(now)
            it.take(frame(10, bytes(8)), now)

    assert asked == [2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5]
    assert it.configured


def test_without_an_answer_for_11_s_it_falls_silent() -> None:
    it = talk()
    it.take(frame(0), 0.0)
    silent = [now for now in range(20) if not (it.tick(float(now)), it.configured)[1]]

    assert silent[0] == 12


def test_it_stops_when_told() -> None:
    it = talk()
    it.take(frame(0), 0.0)
    it.take(frame(11), 1.0)

    assert not it.configured


def test_it_obeys_before_it_is_asked() -> None:
    answer = talk().take(frame(100, b"abcd"), 0.0)

    assert answer.delivered is not None
    assert answer.delivered.startswith(b"abcd")


def test_a_short_payload_is_filled_up_with_what_came_before() -> None:
    it = talk()
    it.take(frame(100, b"abcdef"), 0.0)

    assert (it.take(frame(100, b"XY"), 0.1).delivered or b"").startswith(b"XYcdef")


def test_what_nobody_listens_to_and_what_is_too_long_are_faults_of_the_host() -> None:
    it = talk()

    assert "id 101" in it.take(frame(101), 0.0).fault
    assert "600 bytes" in it.take(Frame(100, bytes(600), 600), 0.0).fault
    assert it.take(frame(6), 0.0) == Answer()

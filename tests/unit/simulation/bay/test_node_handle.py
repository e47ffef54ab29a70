from __future__ import annotations

from pirate_sm.robot.rosserial.frames import SerialFrame, TopicInfo
from pirate_sm.simulation.bay.node_handle import NodeHandle, NodeReply

SAYS = TopicInfo(125, "state", "pirate_msgs/State", "0123456789abcdef" * 2, 512, "publishes")
HEARS = TopicInfo(100, "go", "pirate_msgs/Setpoint_Array", "0123456789abcdef" * 2, 512, "takes")


def node() -> NodeHandle:
    return NodeHandle([SAYS], [HEARS])


def frame(topic: int, payload: bytes = b"") -> SerialFrame:
    return SerialFrame(topic, payload)


def test_it_asks_the_time_then_names_publishers_then_subscribers() -> None:
    says = node().take(frame(0), 1.0).says

    assert [message.topic for message in says] == [10, 0, 1]
    assert says[0].payload == bytes(8)


def test_it_says_nothing_by_itself_before_it_is_asked() -> None:
    it = node()

    assert [it.tick(float(now)) for now in range(60)] == [()] * 60
    assert not it.configured


def test_it_asks_the_time_every_two_and_a_half_seconds() -> None:
    it = node()
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
    it = node()
    it.take(frame(0), 0.0)
    silent = [now for now in range(20) if not (it.tick(float(now)), it.configured)[1]]

    assert silent[0] == 12


def test_it_stops_when_told() -> None:
    it = node()
    it.take(frame(0), 0.0)
    it.take(frame(11), 1.0)

    assert not it.configured


def test_it_obeys_as_soon_as_it_has_been_asked_and_also_when_it_has_fallen_silent() -> None:
    it = node()

    assert it.take(frame(100, b"abcd"), 0.0).delivered is None
    it.take(frame(0), 0.1)
    it.take(frame(11), 0.2)
    assert (it.take(frame(100, b"abcd"), 0.3).delivered or b"").startswith(b"abcd")


def test_a_short_payload_is_filled_up_with_what_came_before() -> None:
    it = node()
    it.take(frame(0), 0.0)
    it.take(frame(100, b"abcdef"), 0.0)

    assert (it.take(frame(100, b"XY"), 0.1).delivered or b"").startswith(b"XYcdef")


def test_what_nobody_listens_to_and_what_is_too_long_are_faults_of_the_host() -> None:
    it = node()

    assert "id 101" in it.take(frame(101), 0.0).fault
    assert "600 bytes" in it.take(SerialFrame(100, bytes(600)), 0.0).fault
    assert it.take(frame(6), 0.0) == NodeReply()

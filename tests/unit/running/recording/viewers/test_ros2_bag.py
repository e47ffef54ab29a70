"""Bags of ROS 2: rosbags, which reads them as ROS does, finds joints, frames and words in them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability

import pirate_sm
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.viewers import ros2_bag
from pirate_sm.running.recording.viewers.ros2_bag import write_bag


class Bag(NamedTuple):
    """What a bag says: each topic's type, the messages with their times, the urdf's elements."""

    types: Mapping[str, str]
    messages: Mapping[str, list[tuple[int, Any]]]
    durable: list[str]

    @property
    def robot(self) -> ElementTree.Element:
        [(_, text)] = self.messages["/robot_description"]
        return ElementTree.fromstring(text.data)


def bag_of(recording: Recording, folder: Path) -> Bag:
    with recorded_mission(recording.header) as loaded:
        write_bag(recording, loaded, folder)
    messages: dict[str, list[tuple[int, Any]]] = {}
    # It has no types of its own, so all definitions are those in the bag.
    with AnyReader([folder]) as reader:
        for connection, time_ns, data in reader.messages():
            found = reader.deserialize(data, connection.msgtype)
            messages.setdefault(connection.topic, []).append((time_ns, found))
        kept = [
            each.topic
            for each in reader.connections
            for qos in each.ext.offered_qos_profiles  # type: ignore[union-attr]
            if qos.durability is QosDurability.TRANSIENT_LOCAL
        ]
        return Bag({each.topic: each.msgtype for each in reader.connections}, messages, kept)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    pirate_sm.run("mitre_bend", seed=2, record=path)
    return read_recording(path)


@pytest.fixture(scope="module")
def bag(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Bag:
    return bag_of(recording, tmp_path_factory.mktemp("bag") / "bag")


@pytest.fixture(scope="module")
def in_space(tmp_path_factory: pytest.TempPathFactory) -> Bag:
    folder = tmp_path_factory.mktemp("space")
    pirate_sm.run("turn_left", record=folder / "run.mcap")
    return bag_of(read_recording(folder / "run.mcap"), folder / "bag")


@pytest.mark.thorough
def test_the_topics_have_types_of_ros(bag: Bag) -> None:
    assert bag.types == {
        "/tf": "tf2_msgs/msg/TFMessage",
        "/joint_states": "sensor_msgs/msg/JointState",
        "/rosout": "rcl_interfaces/msg/Log",
        "/robot_description": "std_msgs/msg/String",
    }
    assert bag.durable == ["/robot_description"]


@pytest.mark.thorough
def test_joints_are_those_of_the_urdf_with_what_was_measured(
    bag: Bag, recording: Recording
) -> None:
    joints = {
        each.get("name") for each in bag.robot.findall("joint") if each.get("type") != "fixed"
    }
    for time_ns, it in bag.messages["/joint_states"]:
        assert set(it.name) == joints
        assert len(it.name) == len(it.position) == len(it.velocity) == len(it.effort)
        assert it.header.stamp.sec * 1_000_000_000 + it.header.stamp.nanosec == time_ns

    first = bag.messages["/joint_states"][0][0]
    last = bag.messages["/joint_states"][-1]
    joint = list(last[1].name).index("gamma_1")
    assert (last[0] - first) / 1e9 == pytest.approx(recording.until_s, abs=0.2)
    assert any(abs(it.position[joint]) > 0.3 for _, it in bag.messages["/joint_states"])
    assert any(isfinite(it.effort[joint]) for _, it in bag.messages["/joint_states"])


@pytest.mark.parametrize(
    ("case", "root"),
    [("bag", "pipe"), pytest.param("in_space", "world", marks=pytest.mark.thorough)],
)
def test_the_frames_are_one_tree_with_every_link_of_the_urdf(
    case: str, root: str, request: pytest.FixtureRequest
) -> None:
    bag: Bag = request.getfixturevalue(case)
    links = {each.get("name") for each in bag.robot.findall("link")}
    for _, it in bag.messages["/tf"]:
        parents = {each.child_frame_id: each.header.frame_id for each in it.transforms}

        assert len(parents) == len(it.transforms)
        assert links <= parents.keys()
        for frame in parents:
            way = [frame]
            while way[-1] in parents:
                way.append(parents[way[-1]])
                assert len(way) <= len(parents) + 1
            assert way[-1] == root
        for each in it.transforms:
            turned = each.transform.rotation
            length = turned.x**2 + turned.y**2 + turned.z**2 + turned.w**2
            assert length == pytest.approx(1, abs=1e-5)


def test_the_log_has_the_levels_of_ros(bag: Bag) -> None:
    lines = [(it.level, it.name, it.msg) for _, it in bag.messages["/rosout"]]

    assert (20, "mitre_bend", "phase enter") in lines
    assert lines[-1][2].startswith("ended succeeded")


@pytest.mark.thorough
def test_a_recording_with_messages_for_viewers_gives_the_same(
    recording: Recording, bag: Bag, tmp_path: Path
) -> None:
    from pirate_sm.running.recording.viewers.complete_recording import write_complete  # noqa: PLC0415

    with recorded_mission(recording.header) as loaded:
        write_complete(recording, loaded, tmp_path / "all.mcap")

    again = bag_of(read_recording(tmp_path / "all.mcap"), tmp_path / "bag")

    counts = {topic: len(each) for topic, each in again.messages.items()}
    assert counts == {topic: len(each) for topic, each in bag.messages.items()}


def test_a_folder_that_is_there_stays_as_it_is(recording: Recording, tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine")

    with recorded_mission(recording.header) as loaded, pytest.raises(FileExistsError):
        write_bag(recording, loaded, tmp_path)

    assert [each.name for each in tmp_path.iterdir()] == ["mine"]


@pytest.mark.thorough
def test_of_a_bag_that_cannot_be_completed_nothing_is_left(
    recording: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def damaged(*_: object) -> None:
        raise RecordingError("damaged")

    monkeypatch.setattr(ros2_bag, "_write", damaged)

    with recorded_mission(recording.header) as loaded, pytest.raises(RecordingError):
        write_bag(recording, loaded, tmp_path / "bag")

    assert not (tmp_path / "bag").exists()


def test_without_rosbags_the_one_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, ros2_bag.__name__)
    for name in [each for each in sys.modules if each.partition(".")[0] == "rosbags"]:
        monkeypatch.setitem(sys.modules, name, None)

    with pytest.raises(UsageError, match=r"pip install 'pirate-sm\[ros2\]'"):
        __import__(ros2_bag.__name__)

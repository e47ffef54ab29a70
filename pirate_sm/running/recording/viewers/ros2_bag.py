"""A recording as a bag of ROS 2: joints, frames, log and URDF as ROS's own messages."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_there, why_hidden
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.viewers.complete_recording import write_complete
from pirate_sm.running.recording.viewers.urdf import urdf
from pirate_sm.running.recording.viewers.viewer_messages import LEVELS

try:
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
except ModuleNotFoundError:
    raise UsageError(
        "bags of ROS 2 need rosbags, which is not installed: pip install 'pirate-sm[ros2]'"
    ) from None

VERSION: Final = 8
"""Version of the bag's description: from 9 on, as Jazzy writes it, Humble and Iron cannot read the
qualities of service (rosbag2, pull request 1476); newer distributions read what older ones wrote
(rosbag2, issue 1895)."""

TOPICS: Final = {
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/log": "rcl_interfaces/msg/Log",
}
"""The topics for viewers that ROS has messages for, with their types."""

_LOG, ROSOUT = "/log", "/rosout"
DESCRIPTION, _TEXT = "/robot_description", "std_msgs/msg/String"

_LEVELS: Final = {LEVELS["info"]: 20, LEVELS["warning"]: 30, LEVELS["error"]: 40}
"""Levels of ``rcl_interfaces/msg/Log`` by those of ``foxglove.Log``."""

_FOREVER: Final = QosTime(0, 0)  # unspecified
_KEPT: Final = Qos(
    QosHistory.KEEP_LAST,
    1,
    QosReliability.RELIABLE,
    QosDurability.TRANSIENT_LOCAL,  # who comes later gets it, too
    _FOREVER,
    _FOREVER,
    QosLiveliness.AUTOMATIC,
    _FOREVER,
    avoid_ros_namespace_conventions=False,
)


def write_bag(recording: Recording, loaded: LoadedMission, folder: Path) -> None:
    """Write a bag, a folder with an MCAP file and its description, which must not exist.

    Raises:
        FileExistsError: There is something of this name.
        OSError: It cannot be written; nothing is left then.
        RecordingError: The recording is damaged, or has nothing to show.
    """
    if is_there(folder) and not why_hidden(folder):
        raise FileExistsError(f"{folder} exists already")
    writer = Writer(folder, version=VERSION, storage_plugin=StoragePlugin.MCAP)
    try:
        with _with_messages(recording, loaded) as whole, writer:
            _write(whole, urdf(loaded.loaded_robot.profile), writer)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


@contextmanager
def _with_messages(recording: Recording, loaded: LoadedMission) -> Iterator[Recording]:
    """Yield the recording, or one made from it that has messages for viewers."""
    if recording.header.viewers:
        yield recording
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "complete.mcap"
        write_complete(recording, loaded, path)
        yield read_recording(path)


def _write(recording: Recording, description: str, writer: Writer) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    make = _Messages(store.types)
    links = {
        topic: writer.add_connection(ROSOUT if topic == _LOG else topic, kind, typestore=store)
        for topic, kind in TOPICS.items()
    }
    kept = writer.add_connection(DESCRIPTION, _TEXT, typestore=store, offered_qos_profiles=[_KEPT])
    described = False
    for message in recording.messages(*TOPICS):
        if not described:
            text = store.types[_TEXT](data=description)
            writer.write(kept, message.time_ns, store.serialize_cdr(text, _TEXT))
            described = True
        content = make.of(message.topic, json.loads(message.data))
        data = store.serialize_cdr(content, TOPICS[message.topic])
        writer.write(links[message.topic], message.time_ns, data)
    if not described:
        raise RecordingError(f"{shown(recording.path)} has nothing to show")


class _Messages:
    """Makes messages of ROS from Foxglove's.

    Args:
        types: The classes of ROS's messages by their names.
    """

    def __init__(self, types: Mapping[str, Any]) -> None:
        self._types = types

    def of(self, topic: str, content: Mapping[str, Any]) -> Any:
        """Return a message of a topic."""
        match topic:
            case "/tf":
                return self._tf(content)
            case "/joint_states":
                return self._joints(content)
            case _:
                return self._log(content)

    def _tf(self, it: Mapping[str, Any]) -> Any:
        vector, quaternion = (
            self._type("geometry_msgs/Vector3"),
            self._type("geometry_msgs/Quaternion"),
        )
        return self._type("tf2_msgs/TFMessage")(
            transforms=[
                self._type("geometry_msgs/TransformStamped")(
                    header=self._header(each["timestamp"], each["parent_frame_id"]),
                    child_frame_id=each["child_frame_id"],
                    transform=self._type("geometry_msgs/Transform")(
                        translation=vector(**_floats(each["translation"])),
                        rotation=quaternion(**_floats(each["rotation"])),
                    ),
                )
                for each in it["transforms"]
            ]
        )

    def _joints(self, it: Mapping[str, Any]) -> Any:
        joints = it["joints"]
        return self._type("sensor_msgs/JointState")(
            header=self._header(it["timestamp"], ""),
            name=[each["name"] for each in joints],
            **{
                key: np.array([each.get(key, nan) for each in joints], dtype=np.float64)
                for key in ("position", "velocity", "effort")
            },
        )

    def _log(self, it: Mapping[str, Any]) -> Any:
        return self._type("rcl_interfaces/Log")(
            stamp=self._time(it["timestamp"]),
            level=_LEVELS[it["level"]],
            name=it["name"],
            msg=it["message"],
            file=it["file"],
            function="",
            line=it["line"],
        )

    def _header(self, stamp: Mapping[str, int], frame: str) -> Any:
        return self._type("std_msgs/Header")(stamp=self._time(stamp), frame_id=frame)

    def _time(self, stamp: Mapping[str, int]) -> Any:
        return self._type("builtin_interfaces/Time")(sec=stamp["sec"], nanosec=stamp["nsec"])

    def _type(self, name: str) -> Any:
        package, _, kind = name.partition("/")
        return self._types[f"{package}/msg/{kind}"]


def _floats(values: Mapping[str, float]) -> dict[str, float]:
    return {name: float(value) for name, value in values.items()}

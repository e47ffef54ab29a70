"""The topics of a robot's firmware, and its arrays and states as messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pirate_sm.core.errors import UsageError
from pirate_sm.core.profile import Profile
from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD, SerialFrame
from pirate_sm.robot.rosserial.message_types import Malformed, MessageType
from pirate_sm.robot.rosserial.messages import Array, link_messages, serial_of
from pirate_sm.robot.rosserial.state_messages import StateReading
from pirate_sm.robot.rosserial.topics import FIRST_OF_THE_DEVICE, Direction, TopicInfo
from pirate_sm.simulation.bay.node_handle import MOST_SUBSCRIBERS
from pirate_sm.simulation.bay.switches import Topic as TopicName


class Wire:
    """The robot's messages.

    Args:
        profile: The robot's profile.
        texts: Message texts by type name, see
            :func:`~pirate_sm.simulation.bay.texts.message_texts`.
        wrong_md5: Topics announced with a wrong md5.

    Attributes:
        publishers: Topics that the firmware sends: states, then echoes.
        subscribers: The topic that it receives.
        one_value: Whether a state message holds one value instead of a board's.

    Raises:
        UsageError: Profile and texts do not fit together.
    """

    def __init__(
        self, profile: Profile, texts: Mapping[str, str], wrong_md5: Sequence[TopicName] = ()
    ) -> None:
        serial = serial_of(profile)
        slots, link = profile.slots, profile.link
        self._steps = tuple(
            link.angle_resolution if slot.unit == "angle" else link.duty_resolution
            for slot in slots
        )
        # The mask built into a firmware whose messages have no field for it.
        zero = set(profile.safe_state.zero)
        self._kept = sum(1 << at for at, slot in enumerate(slots) if slot.name not in zero)
        self._messages = messages = link_messages(texts, serial, len(slots))
        self.one_value = serial.state.layout == "value"
        self._check_room(max((len(board.channels) for board in profile.boards), default=0))

        def announced(
            number: int, name: TopicName, topic: str, kind: MessageType, way: Direction
        ) -> TopicInfo:
            md5 = kind.md5[::-1] if name in wrong_md5 else kind.md5
            return TopicInfo(number, topic, kind.name, md5, LONGEST_PAYLOAD, way)

        takes, says = FIRST_OF_THE_DEVICE, FIRST_OF_THE_DEVICE + MOST_SUBSCRIBERS
        state, echo, setpoints = messages.state.type, messages.echo.type, messages.setpoints.type
        self.publishers = (
            announced(says, "state", serial.state.topic, state, "publishes"),
            announced(says + 1, "echo", serial.echo.topic, echo, "publishes"),
        )
        self.subscribers = (
            announced(takes, "setpoints", serial.setpoints.topic, setpoints, "takes"),
        )

    def _check_room(self, most: int) -> None:
        state = self._messages.state
        if not self.one_value and 0 < state.room < most:
            raise UsageError(
                f"{state.type.name}.msg has room for {state.room} values, and a board has {most} "
                "channels"
            )

    def state(self, board: int, channel: int, counts: Sequence[float]) -> SerialFrame:
        """Return the frame with the values of a board.

        Args:
            board: Number of the board.
            channel: Number of the channel, if a message holds one value.
            counts: Raw counts of this channel, or of all.
        """
        reading = StateReading(board, channel, tuple(counts))
        return SerialFrame(self.publishers[0].number, self._messages.state.pack(reading))

    def echo(self, array: Array) -> SerialFrame:
        """Return the frame that echoes this array."""
        payload = self._messages.echo.pack(array.number, array.counts, array.hold or 0)
        return SerialFrame(self.publishers[1].number, payload)

    def array(self, buffer: bytes) -> Array | None:
        """Return the array at the beginning of a receive buffer; None if there is none."""
        try:
            array = self._messages.setpoints.unpack(buffer, whole=False)
        except Malformed:
            return None
        return array if array.hold is not None else array._replace(hold=self._kept)

    def values(self, array: Array) -> tuple[float, ...]:
        """Return the array as duty cycles and angles in rad."""
        pairs = zip(array.counts, self._steps, strict=True)
        return tuple(count * step for count, step in pairs)

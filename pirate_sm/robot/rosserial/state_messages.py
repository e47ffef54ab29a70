"""State messages, one value or one board each, as a robot's ``.msg`` texts define them."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.profile import StateTopic
from pirate_sm.robot.rosserial.message_types import MessageType


class StateReading(NamedTuple):
    """The content of one State message.

    Attributes:
        board: Number of the board.
        channel: Number of the channel; -1 if ``values`` are all channels of the board.
        values: Raw counts.
    """

    board: int
    channel: int
    values: tuple[float, ...]


class StateCodec:
    """Packs and unpacks state messages of one type, in either layout.

    Attributes:
        type: The message type.
        room: How many values one message can hold; 0 for any number.

    Raises:
        UsageError: The type lacks a field.
    """

    def __init__(self, kind: MessageType, topic: StateTopic) -> None:
        self.type = kind
        self._topic = topic
        self._by_board = topic.layout == "board"
        plain = (topic.board,) if self._by_board else (topic.board, topic.channel, topic.value)
        for name in plain:
            if kind.field(name).size is not None:
                raise UsageError(f"{kind.name}.msg: '{name}' must be one number")
        size = kind.field(topic.values).size if self._by_board else 1
        if size is None:
            raise UsageError(f"{kind.name}.msg: '{topic.values}' must be an array of numbers")
        self.room = size

    def pack(self, reading: StateReading) -> bytes:
        """Return the payload with this content."""
        topic, values = self._topic, reading.values
        if self._by_board:
            return self.type.pack({topic.board: reading.board, topic.values: values})
        content = {topic.board: reading.board, topic.channel: reading.channel}
        return self.type.pack({**content, topic.value: values[0]})

    def unpack(self, payload: bytes) -> StateReading:
        """Return the content of this payload.

        Raises:
            Malformed: The payload does not fit the type.
        """
        message, topic = self.type.unpack(payload), self._topic
        board = int(getattr(message, topic.board))
        if self._by_board:
            return StateReading(board, -1, tuple(getattr(message, topic.values).tolist()))
        value = float(getattr(message, topic.value))
        return StateReading(board, int(getattr(message, topic.channel)), (value,))

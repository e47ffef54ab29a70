"""Shows a run while it is under way: a WebSocket on loopback for Foxglove and Lichtblick."""

from __future__ import annotations

import json
from typing import Final

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.running.recording.viewers.viewer_messages import ViewerChannel

HOST: Final = "127.0.0.1"
PORT: Final = 8765
"""The port that viewers try first."""


class Live:
    """Serves messages to viewers until it is closed.

    Raises:
        UsageError: The extra is not installed, or the port is in use.
    """

    def __init__(self, port: int = PORT) -> None:
        try:
            import foxglove  # noqa: PLC0415 - an extra
        except ModuleNotFoundError:
            raise not_installed("--live", "foxglove-sdk", "live") from None
        self._foxglove = foxglove
        self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="pirate_sm", host=HOST, port=port, context=self._context
            )
        except (OSError, RuntimeError) as error:
            raise UsageError(f"--live cannot serve on {HOST}:{port}: {error}") from None
        self._channels: dict[str, foxglove.Channel] = {}

    @property
    def address(self) -> str:
        """Return the address for viewers."""
        return f"ws://{HOST}:{self._server.port}"

    def show(self, channel: ViewerChannel, time_ns: int, data: bytes) -> None:
        """Send the message to the viewers that have subscribed to its topic."""
        sink = self._channels.get(channel.topic)
        if sink is None:
            schema = self._foxglove.Schema(
                name=channel.schema_name,
                encoding="jsonschema",
                data=json.dumps(channel.schema).encode(),
            )
            sink = self._foxglove.Channel(
                channel.topic, schema=schema, message_encoding="json", context=self._context
            )
            self._channels[channel.topic] = sink
        sink.log(data, log_time=time_ns)

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()

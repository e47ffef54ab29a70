"""The names of our detectors, which a shell can be given without importing any of them."""

from __future__ import annotations

from collections.abc import Mapping

GROUP = "pirate_sm.detectors"
"""Of the entry points with which other packages add some."""

BY_CAMERA = "vision"
"""The detector whose argument is a camera."""

BY_SOCKET = "socket"
"""The detector that opens a socket, for programs that write to it."""

ABOUT: Mapping[str, str] = {
    "sim": "the simulator, which knows where the robot is",
    "odometry": "dead reckoning by wheels and joints",
    "signals": "conditions on the robot's own signals",
    "operator": "the operator, with a key for each word",
    BY_SOCKET: "programs that write to a socket: socket, socket:/PATH or socket:HOST:PORT",
    BY_CAMERA: "a camera over the setup: vision:NAME",
}
"""A line about each."""

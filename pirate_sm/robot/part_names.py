"""The names of our backends and detectors, which a shell can be given without importing any."""

from __future__ import annotations

from collections.abc import Mapping

# --- backends -------------------------------------------------------------------------------------


BACKEND_GROUP = "pirate_sm.backends"
"""Of the entry points with which other packages add some."""

BACKENDS: Mapping[str, str] = {
    "bay": "the serial link to an emulated robot, in virtual time",
    "physics": "rigid bodies with friction, by MuJoCo: in a plane, or in space in a round pipe",
    "serial": "the real robot, at a serial port",
    "sim": "the kinematic simulator",
    "trace": "nothing moves; shows what would be sent",
}
"""A line about each."""


# --- detectors ------------------------------------------------------------------------------------


DETECTOR_GROUP = "pirate_sm.detectors"
"""Of the entry points with which other packages add some."""

BY_CAMERA = "vision"
"""The detector whose argument is a camera."""

BY_SOCKET = "socket"
"""The detector that opens a socket, for programs that write to it."""

DETECTORS: Mapping[str, str] = {
    "sim": "the simulator, which knows where the robot is",
    "odometry": "dead reckoning by wheels and joints",
    "signals": "conditions on the robot's own signals",
    "operator": "the operator, with a key for each word",
    BY_SOCKET: "programs that write to a socket: socket, socket:/PATH or socket:HOST:PORT",
    BY_CAMERA: "a camera over the setup: vision:NAME",
}
"""A line about each."""

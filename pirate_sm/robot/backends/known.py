"""The names of our backends, which a shell can be given without importing any of them."""

from __future__ import annotations

from collections.abc import Mapping

GROUP = "pirate_sm.backends"
"""Of the entry points with which other packages add some."""

ABOUT: Mapping[str, str] = {
    "bay": "the serial link to an emulated robot, in virtual time",
    "physics": "rigid bodies with friction, by MuJoCo: in a plane, or in space in a round pipe",
    "serial": "the real robot, at a serial port",
    "sim": "the kinematic simulator",
    "trace": "nothing moves; shows what would be sent",
}
"""A line about each."""

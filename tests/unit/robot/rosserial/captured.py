"""Frames captured from rosserial's own C++ client and its own Python host.

Both ends of the link use one codec, which could agree with itself and still be wrong. These bytes
are what it is held to.
"""

from __future__ import annotations

from typing import NamedTuple


class Captured(NamedTuple):
    """A whole frame, its topic and its payload; bytes in hexadecimal digits."""

    wire: str
    topic: int
    payload: str


_ARRAY = "020000000100ffff" + "00" * 30 + "e903"
_STATE_TOPIC = (
    "7d00050000007374617465110000007069726174655f6d7367732f537461746520000000"
    "373034636463623762313238666530323430333339616638633730356162616500020000"
)
_ARRAY_TOPIC = (
    "64000e000000736574706f696e745f61727261791a0000007069726174655f6d7367732f536574706f696e745f"
    "41727261792000000039316362323136636230316661656233366266333766363839366166316165610002"
    "0000"
)

REQUEST = Captured("fffe0000ff0000ff", 0, "")
TX_STOP = Captured("fffe0000ff0b00f4", 11, "")
TIME_REQUEST = Captured("fffe0800f70a000000000000000000f5", 10, "00" * 8)
TIME_REPLY = Captured("fffe0800f70a008cdd006b33718a22d1", 10, "8cdd006b33718a22")
LOG = Captured("fffe0e00f1070001090000006261792072656164797d", 7, "0109000000626179207265616479")
STATE = Captured("fffe0600f97d0004030080c943ef", 125, "04030080c943")
ARRAY = Captured(f"fffe2800d76400{_ARRAY}ae", 100, _ARRAY)
ECHO = Captured(f"fffe2800d77e00{_ARRAY}94", 126, _ARRAY)
PUBLISHER = Captured(f"fffe4800b70000{_STATE_TOPIC}49", 0, _STATE_TOPIC)
SUBSCRIBER = Captured(f"fffe5a00a50100{_ARRAY_TOPIC}62", 1, _ARRAY_TOPIC)

ALL = {name: each for name, each in list(globals().items()) if isinstance(each, Captured)}

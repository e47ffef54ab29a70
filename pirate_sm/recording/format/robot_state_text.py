"""The robot state after an earlier mission, as text, for the start of the next one."""

from __future__ import annotations

import json
from typing import Any

from pirate_sm.engine.robot.robot_state import Mark, RobotState
from pirate_sm.recording.format.json_values import NUMBERS, text, whole


def body_to_text(body: RobotState | None) -> str:
    """Return the robot state between two missions as JSON; empty for none."""
    if body is None:
        return ""
    content = {
        "configuration": body.configuration,
        "values": NUMBERS.encode(body.values) if NUMBERS.encode else [],
        "marks": sorted(body.marks),
        "next_id": body.next_id,
        "seeking": sorted(body.seeking),
        "sent": body.sent,
    }
    return json.dumps(content, allow_nan=False)


def body_from_text(written: str) -> RobotState | None:
    """Return the robot state in the output of :func:`body_to_text`.

    Raises:
        ValueError: The text is not a robot state.
    """
    if not written:
        return None
    content: dict[str, Any] = json.loads(written)
    try:
        return RobotState(
            configuration=whole(content["configuration"]),
            values=NUMBERS.decode(content["values"]),
            marks=frozenset(_mark(*mark) for mark in content["marks"]),
            next_id=whole(content["next_id"]),
            seeking=frozenset(map(whole, content["seeking"])),
            sent=content["sent"] is True,
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"no body: {error!r}") from None


def _mark(kind: Any, which: Any, command: Any) -> Mark:
    if kind not in ("region", "part"):
        raise ValueError(f"'{text(kind)}' cannot be marked")
    return Mark("region" if kind == "region" else "part", whole(which), whole(command))

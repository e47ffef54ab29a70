"""What a recording is told of a run that has been prepared."""

from __future__ import annotations

from datetime import datetime
from math import isinf
from typing import TYPE_CHECKING, Any

from pirate_sm.engine.state import EngineState
from pirate_sm.wiring.prepared import Prepared

if TYPE_CHECKING:
    from pirate_sm.recording.format.header import RunHeader
    from pirate_sm.recording.viewers.viewer_messages import ViewerSnapshot


def run_header(prepared: Prepared, factor: float, began: datetime) -> RunHeader:
    """Return what the recording of a run begins with.

    Args:
        prepared: The run.
        factor: Mission seconds per second of the wall.
        began: When the run began.
    """
    from pydantic_core import to_jsonable_python

    from pirate_sm.recording.format.header import header_of

    options: dict[str, Any] = to_jsonable_python(prepared.order)
    options["speed"] = "max" if isinf(factor) else factor
    return header_of(
        prepared.loaded,
        backend=prepared.order.backend,
        nominal=prepared.engine.nominal,
        detector=prepared.detector,
        options=options,
        began=began,
    )


def shown_to_viewers(prepared: Prepared, state: EngineState | None) -> ViewerSnapshot | None:
    """Return what viewers are shown of this moment; None before the engine has started."""
    from pirate_sm.recording.viewers.viewer_messages import ViewerSnapshot

    if state is None:
        return None
    if prepared.wheels is not None:
        return ViewerSnapshot(state, prepared.wheels(), True)
    taken = prepared.reckoned() if prepared.reckoned else None
    return ViewerSnapshot(state, taken.wheels if taken else None, False)

"""Machine code of the simulator: built with the package, or compiled on a first call."""

from __future__ import annotations

from pirate_sm.simulation.machine_code.built_library import (
    compiled,
    compiled_module,
    is_kept,
    own_call,
)

__all__ = ["compiled", "compiled_module", "is_kept", "own_call"]

"""Types of the arrays in this package."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float64]
"""Points are rows: (N, 2) in the picture or a plane, (N, 3) in space."""

Flags: TypeAlias = npt.NDArray[np.bool_]
"""Whether something is so, for each point."""

Frame: TypeAlias = npt.NDArray[np.uint8]
"""A picture: (height, width, 3), blue, green, red."""

Gray: TypeAlias = npt.NDArray[np.uint8]
"""A picture of one channel: (height, width)."""

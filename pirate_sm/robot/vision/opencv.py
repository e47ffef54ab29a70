"""OpenCV, imported once with its settings, and the types of the arrays in this package.

It has no output of its own, and one thread.
"""

from __future__ import annotations

import os
from typing import Any, TypeAlias

from pirate_sm.core.errors import not_installed

# It reads these when it is imported. Without them, a camera that is missing prints ten lines.
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

try:
    import cv2 as _cv2
    import numpy as np
    import numpy.typing as npt
except ImportError:
    raise not_installed("a camera", "opencv", "vision") from None

cv2: Any = _cv2
# It may be imported already, as in a notebook.
if os.environ["OPENCV_LOG_LEVEL"] == "SILENT":
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
# The control loop runs beside it: one core is enough (docs/measurements.md).
cv2.setNumThreads(1)


# --- arrays ---------------------------------------------------------------------------------------


Floats: TypeAlias = npt.NDArray[np.float64]
"""Points are rows: (N, 2) in the picture or a plane, (N, 3) in space."""

Flags: TypeAlias = npt.NDArray[np.bool_]
"""Whether something is so, for each point."""

Frame: TypeAlias = npt.NDArray[np.uint8]
"""A picture: (height, width, 3), blue, green, red."""

Gray: TypeAlias = npt.NDArray[np.uint8]
"""A picture of one channel: (height, width)."""

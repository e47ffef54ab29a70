"""What stands in for the window of MuJoCo's viewer, where there is no display."""

from __future__ import annotations

from types import SimpleNamespace


class Window:
    """Stands in for MuJoCo's window."""

    def __init__(self) -> None:
        self.cam = SimpleNamespace(lookat=[0.0] * 3, distance=0.0, elevation=0.0)
        self.shown, self.open = 0, True

    def is_running(self) -> bool:
        return self.open

    def sync(self) -> None:
        self.shown += 1

    def close(self) -> None:
        self.open = False

"""What holds for every story at the console."""

from __future__ import annotations

import pytest
from textual._compositor import Compositor


@pytest.fixture(autouse=True)
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw only what somebody looks at: without a terminal an app throws its frames away."""
    draw = Compositor.render_update

    def drawn_if_full(compositor: Compositor, full: bool = False, **how: object) -> object:
        if full:
            return draw(compositor, full, **how)
        compositor._dirty_regions.clear()
        return None

    monkeypatch.setattr(Compositor, "render_update", drawn_if_full)

"""What holds for every story at the console."""

from __future__ import annotations

from typing import Any

import pytest
from textual._compositor import Compositor
from textual.css.stylesheet import Stylesheet

_PARSED: dict[tuple[object, ...], Any] = {}


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


@pytest.fixture(autouse=True)
def _parsed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parse a stylesheet once for all consoles of one theme."""
    parse = Stylesheet._parse_rules

    def parsed(sheet: Stylesheet, *of: Any, **how: Any) -> Any:
        key = (*of, *how.items(), *sheet._variables.items())
        if key not in _PARSED:
            _PARSED[key] = parse(sheet, *of, **how)
        return _PARSED[key]

    monkeypatch.setattr(Stylesheet, "_parse_rules", parsed)

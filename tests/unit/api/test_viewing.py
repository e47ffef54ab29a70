"""The viewer of the backend `physics`, asked for from Python."""

from __future__ import annotations

import gc
import sys
from typing import Any

import mujoco.viewer
import pytest
from viewer_window import Window

import pirate_sm

from .conftest import PATROL


@pytest.fixture
def window(monkeypatch: pytest.MonkeyPatch) -> Window:
    """What MuJoCo opens in this test, on a computer with a display."""
    opened = Window()
    monkeypatch.setenv("DISPLAY", ":7")

    def launch(*model: Any, **options: Any) -> Window:
        return opened

    monkeypatch.setattr(mujoco.viewer, "launch_passive", launch)
    return opened


@pytest.mark.thorough
def test_a_session_shows_what_has_happened_and_closes_its_window(window: Window) -> None:
    with pirate_sm.session(PATROL, "physics", view=True) as session:
        session.advance(0.5)
        assert window.shown >= 20
        assert window.open
    del session
    gc.collect()
    assert not window.open


@pytest.mark.thorough
def test_a_run_is_shown_to_its_end_and_is_the_same_as_unseen(window: Window) -> None:
    seen = pirate_sm.run(PATROL, "physics", view=True)
    assert window.shown > 100
    assert repr(seen.signals) == repr(pirate_sm.run(PATROL, "physics").signals)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no variable tells of a display")
def test_without_a_display_nothing_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(pirate_sm.UsageError, match="no display here for MuJoCo's viewer") as caught:
        pirate_sm.run(PATROL, "physics", view=True)
    assert "leave view out" in str(caught.value)


def test_without_the_extra_its_name_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for module in [name for name in sys.modules if name.startswith("pirate_sm.simulation.mujoco")]:
        monkeypatch.delitem(sys.modules, module)
    with pytest.raises(pirate_sm.UsageError, match=r"pip install 'pirate-sm\[physics\]'"):
        pirate_sm.run(PATROL, "physics", view=True)

"""Charts that are explored here are kept where no other test and no user sees them."""

from __future__ import annotations

import pytest

from pirate_sm.core._loading import chart_exploration as chart_cache
from pirate_sm.core.kept_entries import Entries


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path_factory.getbasetemp() / "cache"
    monkeypatch.setattr(chart_cache, "charts", lambda: Entries(folder))

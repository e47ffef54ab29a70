"""Which names `--backend` takes."""

from __future__ import annotations

from importlib import metadata
from typing import Any

import pytest

from pirate_sm.cli.options.common import backend_name

from .conftest import NEWT


def test_a_name_that_is_none_is_refused_with_those_that_there_are(pirate_run: Any) -> None:
    result = pirate_run(NEWT / "patrol.yaml", "--backend", "simm")

    assert result.exit_code == 2
    assert "'simm' is not one of 'serial', 'sim', 'trace'." in result.stderr


def test_a_backend_of_another_package_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    another = metadata.EntryPoint("ours", "elsewhere:make", "pirate_sm.backends")
    monkeypatch.setattr(metadata, "entry_points", lambda group: metadata.EntryPoints([another]))

    assert backend_name("ours") == "ours"
    with pytest.raises(ValueError, match="'hours' is not one of 'ours', 'serial', 'sim', 'trace'"):
        backend_name("hours")

"""`pirate page`: what it refuses to show."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from typer.testing import Result


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["nowhere.yaml"], "there is no mission at 'nowhere.yaml'"),
        (["mitre_bend", "a.mcap"], "a page shows one mission, one run, or two runs"),
        (["a.mcap", "b.mcap", "c.mcap"], "a page shows one run, or two"),
        (["a.mcap", "--pipe", "mitre_90"], "--robot, --pipe and --margins are for the page of a"),
        (["a.mcap", "--margins", "results"], "--margins are for the page of a mission"),
        (["mitre_bend", "--margins", "nowhere"], "no results of a campaign in 'nowhere'"),
        (["mitre_bend", "--pipe", "nowhere"], "there is no pipe 'nowhere'"),
        (["a.mcap"], "a.mcap cannot be read"),
        (["mitre_bend", "--forecast", "times.yaml"], "--forecast is for the page of one run"),
    ],
)
def test_what_cannot_be_shown_is_refused_with_the_reason(
    pirate: Callable[..., Result], words: list[str], why: str
) -> None:
    result = pirate("page", *words)
    assert result.exit_code == 2
    assert why in result.output

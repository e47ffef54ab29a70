from math import nan

import pytest

from pirate_sm.cli.commands.fit import estimate_text
from pirate_sm.lab.fitting.measurements import Estimate


@pytest.mark.parametrize(
    ("estimate", "text"),
    [
        (Estimate(0.3, 0.29, 0.31), "0.300 Nm [0.290, 0.310]"),
        (Estimate(0.3), "0.300 Nm"),
        (Estimate(reason="nothing slipped"), "unknown: nothing slipped"),
        (Estimate(nan, low=0.1, reason="no slip"), "at least 0.100 Nm, unknown: no slip"),
    ],
)
def test_an_estimate_is_told_with_its_interval_or_why_it_is_unknown(
    estimate: Estimate, text: str
) -> None:
    assert estimate_text(estimate, " Nm") == text

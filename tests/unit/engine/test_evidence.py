"""Evidence: its age, and the connection that it belongs to."""

from __future__ import annotations

from math import isnan

import pytest
from driving import IDLE

from pirate_sm.engine.evidence import NOTHING, Evidence
from pirate_sm.model import events as ev


def test_the_age_of_evidence_is_computed_when_it_is_asked_for():
    assert Evidence("sensor", 12.0, 0).age_s(14.5) == 2.5
    assert isnan(NOTHING.age_s(14.5))


@pytest.mark.parametrize("code", ["firmware.reset", "link.interrupted"])
def test_each_return_of_the_controller_begins_the_next_connection(drive, code):
    driver = drive(f"on_fault: [{{fault: [{code}, robot.stuck], then: continue}}]\n{IDLE}")
    assert driver.state.connection == 0

    driver.give(ev.FaultReport("robot.stuck", "it does not move"))
    assert driver.state.connection == 0

    driver.give(ev.FaultReport(code, "it is back"))
    driver.give(ev.FaultReport(code, "it is back again"))
    driver.run(driver.now + 1.0)
    assert driver.state.connection == 2

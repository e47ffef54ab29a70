from __future__ import annotations

from math import nan

import pytest

from pirate_sm.cli.output.event_lines import SaysWhyItWaits
from pirate_sm.core.effects import Ended
from pirate_sm.robot.backends.serial.link.health import LinkHealth
from pirate_sm.running.runtime.ending import Stop, StopRequests

WELL = LinkHealth(9, 0, 3, 0, 0, nan, 0.0, "")
AWAY = WELL._replace(trouble="nothing comes from the robot", silent_s=2.5, patience_s=7.6)


def test_it_is_said_once_for_what_a_stop_waits(capsys: pytest.CaptureFixture[str]) -> None:
    requests, health = StopRequests(), [AWAY]
    waits = SaysWhyItWaits(lambda: health[0], requests)

    waits.pulse(1.0)
    assert capsys.readouterr().err == ""
    requests.ask(Stop("interrupted by Ctrl-C", 130))
    waits.pulse(1.1)
    waits.pulse(1.2)
    assert capsys.readouterr().err == (
        "interrupted by Ctrl-C: no word for 2.5 s; its wheels stood when it was last heard; "
        "a stop waits for it, given up in 8 s (nothing comes from the robot); "
        "a second signal ends it immediately\n"
    )


def test_a_stop_that_waits_for_no_link_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    requests = StopRequests()
    requests.ask(Stop("interrupted by Ctrl-C", 130))

    SaysWhyItWaits(lambda: WELL, requests).pulse(1.0)

    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("stopped", [True, False])
def test_it_is_said_that_a_robot_is_waited_for_that_has_not_confirmed_its_stop(
    stopped: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    waits = SaysWhyItWaits(lambda: WELL._replace(stopped=stopped), StopRequests())

    waits.see((Ended("interrupted", "Ctrl-C"),), 1.0)

    assert ("has not confirmed that it stopped" in capsys.readouterr().err) == (not stopped)

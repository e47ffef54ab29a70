"""Waits among the steps, changes of signals since a wait began, and rounds of a repeat."""

from __future__ import annotations

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core._loading.problems import LoadError

ENDS = "\nends: {e: {succeed: ok}, bad: {fail: 'bad: {cause}'}}\n"


def logs(driver) -> list[str]:
    return [each.message for each in driver.of(fx.Log)]


STATIONS = (
    """
start: a
phases:
  a:
    on_failure: bad
    do:
      - repeat:
          times: 3
          do:
            - {wait: [{when: change(theta_1) >= 1 rad}], within: {time: 5 s}}
            - {log: "station {round} of {rounds}"}
    go: e
"""
    + ENDS
)


def test_a_change_is_unknown_where_its_signal_was_unknown_when_the_wait_began(drive):
    driver = drive(STATIONS)
    driver.run(5.2, theta_1=1.0)

    assert not any(line.startswith("station") for line in logs(driver))
    assert driver.ended.end == "bad"


def test_relative_distances_are_driven_one_after_the_other(drive):
    until_known = """
  b: {wait: [{when: known(theta_1), go: a}], within: {time: 1 s, go: bad}}
"""
    body = STATIONS.replace("start: a", "start: b").replace("phases:\n", f"phases:{until_known}")
    driver = drive(body)
    driver.show(0.1, theta_1=7.0)
    driver.show(0.2, theta_1=7.9)
    assert logs(driver) == []
    driver.show(0.3, theta_1=8.0)
    assert logs(driver) == ["station 1 of 3"]
    driver.show(0.4, theta_1=8.9)
    assert logs(driver) == ["station 1 of 3"]
    driver.show(0.5, theta_1=9.1)
    driver.show(0.6, theta_1=10.2)

    assert logs(driver) == ["station 1 of 3", "station 2 of 3", "station 3 of 3"]
    assert driver.ended.outcome == "succeeded"


def test_a_wait_that_runs_out_fails_like_any_step(drive):
    driver = drive(STATIONS)
    driver.run(5.2)

    assert driver.ended.outcome == "failed"
    assert driver.ended.end == "bad"
    assert "the wait of a" in driver.ended.message
    assert "lasted longer than 5 s: it awaited 'change(theta_1) >= " in driver.ended.message
    assert "(theta_1 shows 0 deg (0 ms old) and was unknown before)" in driver.ended.message
    fired = driver.of(fx.TriggerFired)[-1]
    assert (fired.trigger, fired.go) == ("within", "fail")


def test_a_wait_that_runs_out_may_be_passed_over(drive):
    driver = drive(
        """
start: a
phases:
  a:
    do:
      - {wait: [{when: detector == close}], within: {time: 2 s}, on_failure: continue}
      - {log: after}
    go: e
"""
        + ENDS
    )
    driver.run(2.2)

    assert logs(driver)[-1] == "after"
    assert driver.ended.outcome == "succeeded"


def test_a_trigger_of_a_step_may_lead_elsewhere(drive):
    driver = drive(
        """
start: a
phases:
  a:
    do:
      - wait: [{after: 1 s}, {when: known(theta_1), go: bad}]
      - {log: after}
    go: e
"""
        + ENDS
    )
    driver.show(0.5, theta_1=1.0)

    assert driver.ended.end == "bad"
    assert logs(driver) == []


def test_a_wait_inside_a_choice_goes_on_behind_it(drive):
    driver = drive(
        """
start: a
phases:
  a:
    do:
      - {choose: [{if: LightingState == Off, do: [{wait: [{after: 1 s}]}]}]}
      - {log: after}
    go: e
"""
        + ENDS
    )
    assert logs(driver) == []
    driver.run(1.2)
    assert logs(driver) == ["after"]


LEGS = (
    """
start: known
phases:
  known: {wait: [{when: known(theta_1), go: a}], within: {time: 1 s, go: bad}}
  a:
    wait: [{when: change(theta_1) >= 2 rad, go: bad}, {after: 1 s, go: b}]
  b:
    do: [{wait: [{after: 1 s}]}]
    wait: [{when: change(theta_1) >= 2 rad, go: e}]
    counts_on: COUNTS_ON
    within: {time: 60 s, go: bad}
"""
    + ENDS
)


@pytest.mark.parametrize(("counts_on", "ended_at"), [("true", 10.1), ("false", 11.6)])
def test_a_wait_that_counts_on_counts_from_where_the_last_one_counted(drive, counts_on, ended_at):
    driver = drive(LEGS.replace("COUNTS_ON", counts_on))
    driver.show(0.1, theta_1=8.0)
    driver.show(0.5, theta_1=9.5)
    driver.run(3.0)
    for theta in (9.9, 10.1, 11.4, 11.6):
        if not driver.ended:
            driver.show(driver.now + 0.1, theta_1=theta)

    assert driver.ended.outcome == "succeeded"
    assert driver.signals["theta_1"] == ended_at


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "a: {wait: [{operator: x, go: e}], within: {time: 1 s, go: e}, counts_on: true}",
            "nothing counts here",
        ),
        ("a: {do: [{if: change(odometry) > 1 m, log: x}], go: e}", "beginning of a wait"),
        ("a: {wait: [{when: change(1 m) > 1 m, go: e}], within: {time: 1 s, go: e}}", "one signal"),
        (
            "a: {wait: [{when: change(detector) > 1 m, go: e}], within: {time: 1 s, go: e}}",
            "needs a number",
        ),
        ("a: {do: [{wait: [{when: detector == close}]}], go: e}", "needs `within"),
        ("a: {wait: [{when: detector == close}], within: {time: 1 s, go: e}}", "needs `go`"),
        ("a: {wait: [{after: 1 s, go: e}], within: {time: 1 s}}", "needs `go`"),
        ("a: {do: [{log: 'station {round}'}], go: e}", "no repeat around"),
    ],
)
def test_what_cannot_be_meant_is_refused(drive, body, said):
    with pytest.raises(LoadError) as caught:
        drive(f"start: a\nphases:\n  {body}{ENDS}")
    assert said in str(caught.value)

from __future__ import annotations

from math import inf

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.views.report.contents import Lane
from pirate_sm.views.report.timeline import Timeline


def lanes(
    *moments: tuple[float, object, list[fx.Effect]], until_s: float = 10.0
) -> dict[str, Lane]:
    timeline = Timeline(("Grip", "Lamp"), nominal=False)
    for at_s, cause, effects in moments:
        timeline.take(at_s, cause, effects)
    return {lane.name: lane for lane in timeline.lanes(until_s)}


def command(status: fx.CommandState, reason: str = "") -> fx.CommandStatus:
    return fx.CommandStatus("Hold", status, reason, "a.yaml:3:1")


def spans(lane: Lane) -> list[tuple[float, float, str, str]]:
    return [span[:4] for span in lane.spans]


def test_each_state_machine_has_a_lane_and_shows_what_is_not_confirmed():
    found = lanes(
        (0.0, None, [fx.StateChange(("Loose", "Off"), ())]),
        (2.0, None, [fx.StateChange(("Held", "Off"), ("Grip",))]),
        (5.0, None, [fx.StateChange(("Held", "Off"), ())]),
    )

    assert spans(found["Grip"]) == [
        (0.0, 2.0, "Loose", "state"),
        (2.0, 5.0, "Held", "unconfirmed"),
        (5.0, 10.0, "Held", "state"),
    ]
    assert spans(found["Lamp"]) == [(0.0, 10.0, "Off", "state")]


def test_a_control_other_than_the_usual_one_has_a_lane():
    timeline = Timeline(("Grip", "Lamp"), nominal=False)
    for at_s, control in ((0.0, ""), (2.0, "gentle"), (3.0, "gentle"), (5.0, "swift"), (7.0, "")):
        timeline.take(at_s, None, [], control)

    (lane,) = timeline.lanes(10.0)

    assert lane.name == "control"
    assert spans(lane) == [(2.0, 5.0, "gentle", "state"), (5.0, 7.0, "swift", "state")]


def test_what_did_not_last_is_not_shown_and_does_not_cut_what_did():
    found = lanes(
        (0.0, None, [fx.StateChange(("Held", "Off"), ())]),
        (2.0, None, [fx.StateChange(("Held", "Off"), ("Grip",)),
                     fx.StateChange(("Held", "Off"), ())]),
    )  # fmt: skip

    assert spans(found["Grip"]) == [(0.0, 10.0, "Held", "state")]


@pytest.mark.parametrize("status", ["done", "failed"])
def test_a_command_lasts_from_being_sent_to_its_end(status):
    found = lanes(
        (1.0, None, [command("sent")]),
        (1.1, None, [command("accepted")]),
        (3.0, None, [command(status, "so it is")]),
    )

    assert spans(found["commands"]) == [(1.0, 3.0, "Hold", status)]
    assert "so it is (a.yaml:3:1)" in found["commands"].spans[0].about


def test_two_commands_of_one_name_stay_two():
    found = lanes(
        (1.0, None, [command("sent")]),
        (2.0, None, [command("done"), command("sent")]),
        (3.0, None, [command("done")]),
    )

    assert len(found["commands"].spans) == 2


@pytest.mark.parametrize("status", ["refused", "skipped"])
def test_a_command_that_was_never_sent_is_a_mark(status):
    found = lanes((1.0, None, [command(status, "impossible")]))

    assert [mark[:3] for mark in found["commands"].marks] == [(1.0, "Hold", status)]


def test_a_command_still_under_way_at_the_end_is_open():
    assert spans(lanes((1.0, None, [command("sent")]))["commands"]) == [(1.0, 10.0, "Hold", "open")]


def test_phases_waits_and_triggers_follow_the_mission_into_what_it_calls_and_back():
    found = lanes(
        (0.0, None, [fx.PhaseChange("go"), fx.PhaseChange("go/other.hold")]),
        (4.0, None, [fx.WaitArmed("go", ("near",), ("way > 1 m",), inf)]),
        (6.0, None, [fx.TriggerFired("go", "near", "rest", "way > 1 m"), fx.PhaseChange("rest")]),
        (8.0, None, [fx.Ended("succeeded", "Well", "fine")]),
    )

    assert spans(found["phase"]) == [
        (0.0, 4.0, "go/other.hold", "phase"),
        (4.0, 6.0, "go", "phase"),
        (6.0, 8.0, "rest", "phase"),
    ]
    assert found["phase"].marks[0][:3] == (8.0, "fine", "end")
    assert spans(found["waits for"]) == [(4.0, 6.0, "way > 1 m", "wait")]
    assert found["triggers"].marks[0].about == "way > 1 m → rest"


def test_faults_warnings_and_what_a_person_does_are_marks():
    found = lanes(
        (1.0, None, [fx.Fault("wheel.dead", "wheel 3 does not turn", "continue")]),
        (2.0, ev.Pause(), []),
        (3.0, None, [fx.Log("warning", "battery"), fx.Log("info", "never mind")]),
        (4.0, None, [fx.Ask("Go on?", ("yes", "no"))]),
        (5.0, ev.Answer("yes"), [fx.Ask("", ())]),
    )

    assert [mark[1:3] for mark in found["faults"].marks] == [
        ("wheel.dead", "fault"),
        ("battery", "warning"),
    ]
    assert [mark.text for mark in found["operator"].marks] == ["pauses", "answers yes"]
    assert spans(found["operator"]) == [(4.0, 5.0, "Go on?", "question")]


def test_a_lane_with_nothing_on_it_is_left_out():
    assert lanes((0.0, None, [fx.Detected("near")])).keys() == {"detector"}


def test_a_region_may_bear_the_name_of_another_lane():
    timeline = Timeline(("commands",), nominal=False)
    timeline.take(0.0, None, [fx.StateChange(("On",), ()), command("sent")])

    assert [(lane.name, lane.spans[0].text) for lane in timeline.lanes(1.0)] == [
        ("commands", "On"),
        ("commands", "Hold"),
    ]

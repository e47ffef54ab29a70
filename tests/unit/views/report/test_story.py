from __future__ import annotations

from math import inf

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core.spelling import listed
from pirate_sm.views.report.contents import Sentence
from pirate_sm.views.report.story import RunEnding, RunFacts, Story, seconds, summary


def story(*moments: tuple[float, object, list[fx.Effect]]) -> list[str]:
    told = Story({"go": "Drive to the bend"}, nominal=False)
    for at_s, cause, effects in moments:
        told.take(at_s, cause, effects)
    ended = told.finish(RunEnding("failed", "Stuck", 9.0))
    return [f"{each.topic} {each.text}".strip() for each in ended]


def test_a_phase_is_told_with_its_purpose_its_commands_and_its_wait():
    found = story(
        (0.0, None, [fx.PhaseChange("go"), fx.CommandStatus("Hold", "sent")]),
        (2.0, None, [fx.CommandStatus("Hold", "done"), fx.CommandStatus("Go", "sent")]),
        (2.1, None, [fx.CommandStatus("Go", "done")]),
        (2.1, None, [fx.WaitArmed("go", ("near",), ("way > 1 m",), inf)]),
        (6.1, None, [fx.TriggerFired("go", "near", "rest", "way > 1 m"), fx.PhaseChange("rest")]),
    )

    assert found == [
        "go Drive to the bend. Hold (2.00 s) and Go done. Waited 4.00 s (way > 1 m), then rest.",
        "Failed after 9.00 s: Stuck.",
    ]


def test_what_goes_wrong_and_what_people_do_have_sentences_of_their_own():
    found = story(
        (0.0, None, [fx.PhaseChange("rest"), fx.CommandStatus("Hold", "sent")]),
        (1.0, None, [fx.Fault("wheel.dead", "wheel 3 does not turn", "continue")]),
        (3.0, None, [fx.CommandStatus("Hold", "failed", "no torque")]),
        (4.0, ev.Pause(), []),
        (5.0, None, [fx.Log("error", "nothing left")]),
    )

    assert found[:-1] == [
        "Fault wheel.dead: wheel 3 does not turn. The mission went on.",
        "Hold failed after 3.00 s: no torque.",
        "The operator pauses.",
        "Error: nothing left.",
    ]


@pytest.mark.parametrize(("fired_s", "over"), [(2.0, True), (2.1, False)])
def test_a_wait_that_was_over_as_it_began_is_noted(fired_s, over):
    told = Story({}, nominal=False)
    told.take(2.0, None, [fx.WaitArmed("go", ("near",), ("way < 1 m",), inf)])
    told.take(fired_s, None, [fx.TriggerFired("go", "near", "rest", "way < 1 m")])

    text = "The wait was over after 0.00 s (way < 1 m)."
    assert told.at_once == ([Sentence(2.0, text, "trouble", "go")] if over else [])


def test_a_story_can_be_told_before_it_is_over_and_goes_on() -> None:
    told = Story({}, nominal=False)
    told.take(0.0, None, [fx.PhaseChange("rest"), fx.WaitArmed("rest", ("near",), ("far",), inf)])
    ending = RunEnding("running", "", 2.0)

    assert [each.text for each in told.finish(ending)] == ["Waited 2.00 s for far."]
    assert [each.text for each in told.finish(ending._replace(at_s=3.0))] == [
        "Waited 3.00 s for far."
    ]


@pytest.mark.parametrize(
    ("counts", "faults", "told"),
    [
        ({"done": 3}, {}, "3 commands were given and done."),
        ({"done": 1}, {}, "1 command was given and done."),
        ({"done": 2, "failed": 1}, {}, "3 commands were given: 2 done and 1 failed."),
        ({}, {}, "No command was given."),
        ({}, {"a.b": 2, "c.d": 1}, "3 faults were reported: a.b (2 times) and c.d."),
    ],
)
def test_a_summary_counts(counts, faults, told):
    ending = RunEnding("succeeded", "There", 12.0)
    lines = summary(RunFacts("m", "Drive", "r", "in x", ending, 1.0, None, counts, faults))

    assert lines[:2] == ("m (drive) ran on r in x.", "It succeeded after 12.0 s: There.")
    assert told in lines
    assert "Its odometer counted 1.00 m." in lines


@pytest.mark.parametrize(
    ("moved_m", "told"),
    [(0.754, "came 0.75 m along"), (-0.754, "came back 0.75 m along"), (-0.001, "came 0.00 m")],
)
def test_a_summary_says_which_way_the_robot_went(moved_m, told):
    ending = RunEnding("succeeded", "There", 12.0)

    assert any(
        told in line for line in summary(RunFacts("m", "", "r", "", ending, None, moved_m, {}, {}))
    )


@pytest.mark.parametrize(
    ("duration_s", "told"), [(0.5, "0.50 s"), (31.24, "31.2 s"), (245.4, "4 min 05 s")]
)
def test_durations_are_told_as_precisely_as_it_matters(duration_s, told):
    assert seconds(duration_s) == told


def test_the_last_two_words_are_joined_by_and():
    assert [listed("a"), listed("ab"), listed("abc")] == ["a", "a and b", "a, b and c"]

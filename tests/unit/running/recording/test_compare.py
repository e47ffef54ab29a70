"""Two runs side by side: where they part, how long each leg took, how far signals are apart."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from recording_runs import ROOT, record

from pirate_sm.core.effects import Ended, Fault
from pirate_sm.core.loading import load_mission
from pirate_sm.running.recording import compare as module
from pirate_sm.running.recording.compare import ComparedRun, Milestone, compare, compared_run, story
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import Rerun
from pirate_sm.running.wiring import Order


def course(tmp_path, name, order):
    recording = record(tmp_path / f"{name}.mcap", order)
    with recorded_mission(recording.header) as loaded:
        return compared_run(recording, loaded)


def test_a_run_is_where_it_is(tmp_path):
    one = course(tmp_path, "one", Order("mitre_bend", seed=1))

    result = compare(one, one)

    assert result.parted is None
    assert all(leg.first_s == leg.second_s for leg in result.legs)
    assert all(each.most == 0 for each in result.deviations)


@pytest.mark.thorough
def test_of_a_long_run_some_frames_are_kept_all_along(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "_MOST_KEPT", 200)
    one = course(tmp_path, "one", Order("mitre_bend", seed=1))

    assert 90 < len(one.times) == len(one.values) <= 200
    assert one.times[-1] == pytest.approx(one.until_s, abs=0.1)
    result = compare(one, one)
    assert result.parted is None
    assert all(each.most == 0 for each in result.deviations)


@pytest.mark.thorough
def test_two_seeds_take_one_course_at_their_own_pace(tmp_path):
    one = course(tmp_path, "one", Order("take_elbow", seed=1))
    other = course(
        tmp_path, "other", Order("take_elbow", seed=2, start_jitter_m=0.05, friction_jitter=0.2)
    )

    result = compare(one, other)

    assert result.parted is None
    assert result.legs[-1].mark == "succeeded: passed"
    assert any(leg.first_s != leg.second_s for leg in result.legs)
    worst = result.deviations[0]
    assert worst.most >= worst.typical > 0
    assert worst.where in {leg.mark for leg in result.legs}


def test_where_they_part_is_told_with_both_sides(tmp_path):
    one = course(tmp_path, "one", Order("mitre_bend", backend="trace"))
    other = course(
        tmp_path, "other", Order("mitre_bend", backend="trace", settings={"give_up": "5 s"})
    )
    assert compare(one, other).parted is None

    stopped = ComparedRun(marks=[*one.marks[:4], Milestone("fault", 9.0)])

    assert compare(one, stopped).parted == (one.marks[4].what, "fault")
    assert compare(one, ComparedRun(marks=one.marks[:4])).parted == (
        one.marks[4].what,
        "nothing more",
    )


def test_a_slower_run_is_compared_where_it_does_the_same():
    def run(pace):
        marks = [Milestone("a", 0.0), Milestone("b", 10.0 * pace)]
        times = [pace * each / 10 for each in range(101)]
        return ComparedRun(
            marks=marks, names=("x",), times=times, values=[(t / pace,) for t in times]
        )

    result = compare(run(1.0), run(2.0))

    assert result.deviations[0].most == pytest.approx(0, abs=0.2)
    assert result.legs[1].lasted_second_s == 2 * result.legs[1].lasted_first_s


def test_deviations_are_sorted_by_their_share_of_the_range_of_their_kind():
    def run(x, peak, z, w):
        marks = [Milestone("a", 0.0), Milestone("b", 5.0), Milestone("c", 10.0)]
        values = [(z, x, peak if each == 7 else 0.0, w, 1.0) for each in range(11)]
        names, kinds = ("z", "x", "y", "w", "v"), ("angle", "way", "way", "turn", "way")
        times = [float(each) for each in range(11)]
        return ComparedRun(marks=marks, names=names, kinds=kinds, times=times, values=values)

    nan = float("nan")
    one, other = run(1.0, 4.0, nan, 2.0), run(3.0, 0.0, 1.0, 2.5)
    other.names = ("x", "z", "y", "w", "unknown")
    other.values = [(x, z, y, w, v) for z, x, y, w, v in other.values]

    found = compare(one, other).deviations

    assert [each.name for each in found] == ["x", "y", "w"], "nothing is known of z in both"
    x, y, w = found
    assert (x.most, x.typical, x.first, x.second) == pytest.approx((2.0, 2.0, 1.0, 3.0))
    assert (x.where, x.at_s) == ("a", 0.0)
    assert (y.most, y.first, y.second) == (4.0, 4.0, 0.0)
    assert y.typical == pytest.approx(4.0 * (10 / 100) ** 0.5)
    assert (y.where, y.at_s) == ("b", 7.0)
    assert w.typical == pytest.approx(0.5)
    unknown_first = compare(other, one).deviations
    assert [each.name for each in unknown_first] == ["x", "y", "w"]
    assert (unknown_first[0].first, unknown_first[0].second) == (3.0, 1.0)


def told(*marks, ending="succeeded (There)"):
    """A run with these marks, which ends with the last of them."""
    milestones = [Milestone(what, at_s) for what, at_s in marks]
    return ComparedRun(milestones, until_s=marks[-1][1], ending=ending)


def test_the_story_of_two_runs_that_part_is_where_and_how_each_ends():
    one = told(("phase drive", 1.0), ("phase halt", 4.0))
    other = told(("phase drive", 1.2), ("phase regrip", 9.0), ending="failed (wheel.dead)")

    assert story(one, other, compare(one, other)) == (
        "A and B part after 'phase drive' (1.0 s, 1.2 s): A comes to 'phase halt', "
        "B to 'phase regrip'; A succeeded (There), B failed (wheel.dead)"
    )


def test_the_story_of_a_slower_run_is_the_leg_that_took_longer():
    one = told(("phase drive", 1.0), ("phase close", 4.0), ("succeeded", 5.0))
    other = told(("phase drive", 1.1), ("phase close", 9.0), ("succeeded", 10.1))

    assert story(one, other, compare(one, other)) == (
        "A and B take the same course; B takes 5.1 s longer than A, mostly up to 'phase close' "
        "(3.0 s in A, 7.9 s in B)"
    )
    assert "B takes 5.1 s less than A" in story(other, one, compare(other, one))


def test_the_story_of_two_like_runs_is_that_nothing_differs():
    one, other = told(("phase drive", 1.0)), told(("phase drive", 1.05))

    assert story(one, other, compare(one, other)) == "A and B take the same course in the same time"


def test_runs_that_end_differently_after_the_same_course_say_so():
    one = told(("phase drive", 1.0), ("failed", 2.0), ending="failed (wheel.dead)")
    other = told(("phase drive", 1.0), ("failed", 2.0), ending="failed (drive: no way)")

    assert story(one, other, compare(one, other)) == (
        "A and B take the same course in the same time; "
        "A failed (wheel.dead), B failed (drive: no way)"
    )


def test_runs_that_are_cut_off_are_the_same_as_far_as_they_are_recorded():
    one = told(("phase drive", 1.0), ending="")
    other = told(("phase drive", 1.0), ending="")
    one.until_s, other.until_s = 5.0, 50.0

    assert story(one, other, compare(one, other)) == (
        "A and B take the same course as far as it is recorded, 5.0 s of A and 50.0 s of B; "
        "A is not recorded to its end, B is not recorded to its end"
    )


def test_runs_without_marks_take_the_time_that_they_take():
    one, other = (ComparedRun(until_s=each, ending="fault (x)") for each in (0.0, 90.0))

    assert story(one, other, compare(one, other)) == (
        "A and B take the same course; B takes 90.0 s longer than A"
    )


def test_the_fault_that_ends_a_run_is_in_its_last_mark(monkeypatch):
    lost = Fault("link.lost", "nothing came for 0.5 s", "stop")
    known = Fault("rule.broken", "a rule that only warns", "continue")
    step = SimpleNamespace(effects=(lost, known, Ended("fault", "lost")), event=None)
    monkeypatch.setattr(module, "rerun", lambda *_, **__: [Rerun(step, None, (), 12.0)])

    run = compared_run(None, load_mission(ROOT / "sequences" / "mitre_bend.yaml"))

    assert run.marks == [Milestone("fault: link.lost", 12.0)]


def test_a_run_that_is_cut_off_at_its_start_has_a_story_too():
    one, other = told(("phase drive", 1.0)), ComparedRun()

    assert story(one, other, compare(one, other)) == (
        "A and B part immediately: A comes to 'phase drive', B to 'nothing more'; "
        "A succeeded (There), B is not recorded to its end"
    )

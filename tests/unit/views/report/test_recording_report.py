from __future__ import annotations

from collections.abc import Callable
from math import hypot, isnan
from pathlib import Path

import pytest

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.read.repair import repair
from pirate_sm.running.wiring import Order
from pirate_sm.views.report.charts import MOST_POINTS, value_at
from pirate_sm.views.report.contents import Chart, Report
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import report_json
from tests.unit.running.recording.recording_runs import record, spoilt_in

Reports = Callable[[str], Report]


def chart(report: Report, title: str) -> Chart:
    return next(each for each in report.charts if each.title == title)


def test_a_run_is_told_from_its_beginning_to_its_end(report: Reports) -> None:
    found = report("bend")

    assert (found.title, found.outcome, found.warnings) == ("mitre_bend", "succeeded", ())
    assert "in the simulator (seed 0), in pipe mitre_90" in found.summary[0]
    assert [each.topic for each in found.story if "Waited" in each.text] == [
        "enter",
        "prepare",
        "pass",
        "close",
        "close",
    ]
    assert found.story[-1].at_s == found.duration_s
    assert all(a.at_s <= b.at_s for a, b in zip(found.story, found.story[1:], strict=False))


def test_faults_stand_in_the_story_and_on_the_timeline(report: Reports) -> None:
    found = report("dead")

    assert found.outcome == "failed"
    assert any(each.kind == "trouble" and "wheel.dead" in each.text for each in found.story)
    marks = next(lane for lane in found.lanes if lane.name == "faults").marks
    assert {mark.text for mark in marks} == {"wheel.dead", "robot.stuck"}


def test_what_made_it_fail_is_told_with_its_time_and_phase_and_is_where_one_begins(
    report: Reports,
) -> None:
    found = report("dead")
    marks = next(lane for lane in found.lanes if lane.name == "faults").marks
    stuck = next(mark for mark in marks if mark.text == "robot.stuck")

    assert found.failure is not None
    assert found.failure.at_s == stuck.at_s < found.duration_s
    assert 0 < found.failure.at_s - found.opens_at_s < 0.01
    assert found.failure.text.startswith("robot.stuck: ")
    assert found.failure.topic == "prepare"


@pytest.mark.thorough
def test_what_led_to_the_failure_is_told_before_it(report: Reports) -> None:
    found = report("twice")

    assert len(found.failures) > 1
    assert found.failures[-1] == found.failure
    assert found.failures[-1].at_s > found.opens_at_s > found.failures[0].at_s
    assert [each.topic for each in found.failures][-1] == "regrip"


@pytest.mark.parametrize("name", ["bend", "trace", "patrol"])
def test_a_run_that_went_well_is_opened_at_its_end(report: Reports, name: str) -> None:
    found = report(name)

    assert (found.failure, found.opens_at_s) == (None, found.duration_s)


def test_what_nearly_went_wrong_stands_at_the_head_with_its_time(report: Reports) -> None:
    for name in ("bend", "twice"):
        found = report(name)
        assert all(0.0 <= each.at_s <= found.duration_s for each in found.doubts)
        assert len({each.text for each in found.doubts}) == len(found.doubts)
    assert report("trace").doubts == ()


@pytest.mark.parametrize("name", ["bend", "patrol"])
def test_the_lanes_of_the_state_machines_are_full_and_do_not_overlap(
    report: Reports, name: str
) -> None:
    found = report(name)
    regions = {"bend": 5, "patrol": 3}[name]

    # A declared state is unconfirmed until the sensors show it.
    shown = {"state", "unconfirmed"}
    full = [lane for lane in found.lanes if lane.spans and lane.spans[0].kind in shown]
    assert len(full) == regions
    for lane in full:
        assert (lane.spans[0].start_s, lane.spans[-1].end_s) == (0.0, found.duration_s)
        for before, after in zip(lane.spans, lane.spans[1:], strict=False):
            assert before.end_s == after.start_s


@pytest.mark.parametrize("name", ["bend", "dead", "patrol"])
def test_the_robot_is_drawn_where_the_simulator_had_it_and_keeps_its_size(
    report: Reports, name: str
) -> None:
    scene = report(name).scene

    assert scene is not None
    assert scene.source == "truth"
    assert len(scene.walls) == 2
    links = len(scene.wheels) - 1
    for points in scene.poses:
        assert len(points) == links + 1
        for number in range(links):
            one, other = points[number], points[number + 1]
            first = scene.poses[0]
            length = hypot(first[number][0] - first[number + 1][0],
                           first[number][1] - first[number + 1][1])  # fmt: skip
            assert hypot(one[0] - other[0], one[1] - other[1]) == pytest.approx(length, abs=2e-3)


def test_lights_parts_and_drives_are_known_at_any_time(report: Reports) -> None:
    scene = report("bend").scene

    assert scene is not None
    assert [light.at for light in scene.lights] == [0.0, 1.0]
    assert (value_at(scene.lights[0].level, 5.0), value_at(scene.lights[0].level, 30.0)) == (0, 1)
    assert [part.name for part in scene.parts] == ["front", "rear"]
    assert [span.kind for span in scene.parts[0].spans[:2]] == ["unconfirmed", "state"]
    # While it drives into the bend every wheel goes forward, whichever wall it is on.
    assert {value_at(wheel.drive, 20.8) for wheel in scene.wheels} == {1.0}


def test_curves_are_in_the_units_of_their_plots_and_signs_agree(report: Reports) -> None:
    found = report("bend")

    odometer, really = chart(found, "Distance").series
    assert odometer.values[-1] == pytest.approx(0.69, abs=0.03)
    assert really.values[-1] == pytest.approx(0.78, abs=0.02)
    at_s = 20.8  # driving straight on
    for wheel in chart(found, "Wheel speeds at the rim").series:
        assert value_at(wheel, at_s) == pytest.approx(150, abs=15)
    for wheel in chart(found, "Slip").series:
        assert abs(value_at(wheel, at_s)) < 20
    assert max(chart(found, "Setpoints: duty cycles").series[1].values) <= 100


@pytest.mark.parametrize("name", ["bend", "dead", "trace", "patrol"])
def test_no_curve_has_more_points_than_a_page_can_show(report: Reports, name: str) -> None:
    for each in report(name).charts:
        for series in each.series:
            assert 0 < len(series.values) == len(series.times_s) <= MOST_POINTS + 2
            assert not all(map(isnan, series.values))


def test_a_trace_has_no_measurements_and_says_why(report: Reports) -> None:
    found = report("trace")

    assert found.scene is None
    assert {each.title for each in found.charts} == {
        "Setpoints: duty cycles",
        "Setpoints: angles",
    } & {each.title for each in found.charts}
    assert found.warnings == ("Nothing moved: commands ended by their nominal time.",)
    assert not any("operator" in each.text for each in found.story)


def test_the_diagram_shows_the_path_taken(report: Reports) -> None:
    assert report("bend").diagram.count("visited") >= 5
    assert 'class="fail visited"' in report("dead").diagram


def test_a_recording_that_was_cut_short_is_told_as_far_as_it_goes(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    whole = recording("bend").read_bytes()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(whole[: len(whole) * 2 // 3])

    found = report_of(read_recording(torn))

    assert found.outcome == "unfinished"
    assert found.summary[1].startswith("The recording breaks off after")
    assert "ends early" in found.warnings[0]
    assert found.opens_at_s == found.duration_s


def test_of_a_recording_without_data_a_sentence_says_that_there_is_nothing_to_show(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    first = read_recording(recording("bend")).content.pieces[0]
    empty = tmp_path / "empty.mcap"
    empty.write_bytes(recording("bend").read_bytes()[: first.at - 9])

    found = report_of(read_recording(empty))

    assert (found.duration_s, found.charts, found.scene) == (0.0, (), None)
    assert "there is nothing to show" in found.warnings[-1]
    assert "Nobody knew where" not in " ".join(found.warnings)


@pytest.mark.thorough
def test_a_gap_is_marked_and_no_setpoint_of_before_it_is_drawn_after_it(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("mitre_bend"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 5), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    (gap,) = again.gaps

    made = report_of(again)

    assert made.gaps == ((gap.from_s, gap.until_s),)
    assert report_json(made)["gaps"] == [[round(gap.from_s, 3), round(gap.until_s, 3)]]
    duties = next(each for each in made.charts if each.title == "Setpoints: duty cycles")
    assert all(isnan(value_at(each, gap.until_s)) for each in duties.series)

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from pirate_sm.running.recording.compare import MissionLeg
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.compared_report import Alignment, compared_report
from pirate_sm.views.report.report_page import fragments, html, report_json


def test_time_is_stretched_between_common_marks_and_runs_on_after_them() -> None:
    legs = [MissionLeg("drive", 2.0, 4.0, 2.0, 4.0), MissionLeg("halt", 10.0, 5.0, 8.0, 1.0)]
    clock = Alignment(legs)

    assert clock([0.0, 2.0, 4.0, 4.5, 5.0, 7.0]) == pytest.approx([0.0, 1.0, 2.0, 6.0, 10.0, 12.0])
    assert Alignment(()).at(3.0) == pytest.approx(3.0)


@pytest.mark.thorough
def test_two_runs_that_part_are_in_one_report(recording: Callable[[str], Path]) -> None:
    first, second = (read_recording(recording(name)) for name in ("bend", "dead"))

    found = compared_report(first, second)
    page, data = fragments(found), report_json(found)

    assert found.summary[0].startswith("A and B part after ")
    assert "A succeeded" in found.summary[0]
    assert "B failed" in found.summary[0]
    assert page["ending"].count('class="outcome') == 2
    assert page["strip"].count('class="pair"') >= 5
    assert {"phase", "phase of B", "faults of B"} <= {lane.name for lane in found.lanes}
    for chart in data["charts"]:
        for series in chart["series"]:
            if "like" in series:
                like = chart["series"][series["like"]]["name"]
                assert (like.removesuffix(" A"), " B") == (series["name"].removesuffix(" B"), " B")
    for lane in found.lanes:
        assert all(span.start_s <= span.end_s for span in lane.spans)
        assert all(a.at_s <= b.at_s for a, b in pairwise(lane.marks))
    assert any(fact.name == "defects" for fact in found.facts)
    assert "</html>" in html(found)


def test_a_run_compared_with_itself_differs_in_nothing(recording: Callable[[str], Path]) -> None:
    run = read_recording(recording("patrol"))

    found = compared_report(run, run)

    assert found.summary[0] == "A and B take the same course in the same time."
    assert found.doubts == ()
    assert found.facts[0].text == "the same seed, parameters and files in A and B"

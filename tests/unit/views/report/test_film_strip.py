"""A film strip shows the robot at each moment that is worth a picture, and only at those."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from pirate_sm.views.report.contents import Lane, Report, Span
from pirate_sm.views.report.film_strip import MOST_PICTURES, StripPicture, pictures, strip

Reports = Callable[[str], Report]


@pytest.fixture
def with_lanes(report: Reports) -> Callable[..., Report]:
    """Gives a report whose timeline has these phases and commands, and nothing else."""

    def make(phases: list[Span], commands: list[Span] | None = None) -> Report:
        lanes = (Lane("phase", tuple(phases)), Lane("commands", tuple(commands or ())))
        until_s = max(span.end_s for span in phases)
        return replace(report("bend"), lanes=lanes, duration_s=until_s)

    return make


def phase(start_s: float, end_s: float, name: str) -> Span:
    return Span(start_s, end_s, name, "phase")


def titles(found: tuple[StripPicture, ...]) -> list[str]:
    return [each.title for each in found]


@pytest.mark.thorough
def test_each_phase_is_shown_as_it_ends(with_lanes: Callable[..., Report]) -> None:
    found = pictures(with_lanes([phase(0.5, 4.0, "go"), phase(4.0, 6.0, "rest")]))

    assert titles(found) == ["start", "go", "rest"]
    assert [each.at_s for each in found] == [0.0, pytest.approx(3.999), 6.0]


def test_commands_that_took_long_are_shown_within_their_phase(
    with_lanes: Callable[..., Report],
) -> None:
    commands = [
        Span(0.5, 2.0, "Hold", "done"), Span(2.0, 2.1, "Lamp", "done"),
        Span(2.1, 3.9, "Go", "done"), Span(4.5, 5.5, "Let", "failed"),
    ]  # fmt: skip
    found = pictures(with_lanes([phase(0.5, 4.0, "go"), phase(4.0, 6.0, "rest")], commands))

    # Go ends with its phase, and Lamp moved nothing.
    assert titles(found) == ["start", "Hold done", "go", "Let failed", "rest"]
    assert [each.about for each in found] == ["", "go", "", "rest", ""]


def test_of_a_failed_run_the_failure_is_shown_and_marked(report: Reports) -> None:
    found = report("dead")
    shown = pictures(found)

    assert [each.kind for each in shown].count("failed") == 1
    failed = next(each for each in shown if each.kind == "failed")
    assert (failed.title, failed.about) == ("robot.stuck", "prepare")
    assert failed.at_s == found.opens_at_s < found.failures[-1].at_s
    assert strip(found).count('<li class="failed">') == 1


@pytest.mark.thorough
def test_everything_that_led_to_a_failure_is_marked_by_what_failed(report: Reports) -> None:
    found = report("twice")
    failed = [each for each in pictures(found) if each.kind == "failed"]

    assert [each.at_s for each in failed] == [each.before_s for each in found.failures]
    assert (failed[-1].title, failed[-1].about) == ("ClampFront", "regrip")
    assert all("(" not in each.title for each in failed)


def test_of_very_many_phases_the_longest_stay(with_lanes: Callable[..., Report]) -> None:
    phases = [phase(2.0 * number, 2.0 * number + 2, f"p{number}") for number in range(99)]
    phases.append(phase(198.0, 258.0, "long"))
    commands = [Span(1.0, 1.6, "Hold", "done")]

    found = pictures(with_lanes(phases, commands))

    assert len(found) == MOST_PICTURES
    assert "long" in titles(found)
    assert "Hold done" not in titles(found)
    assert [each.at_s for each in found] == sorted(each.at_s for each in found)


@pytest.mark.parametrize("name", ["bend", "patrol"])
def test_every_picture_is_of_one_size_with_all_wheels_in_it(report: Reports, name: str) -> None:
    found = report(name)
    assert found.scene is not None
    text = strip(found).replace("<wbr>", "")
    svgs = [ElementTree.fromstring(part + "</svg>") for part in _svgs(text)]

    assert len(svgs) == len(pictures(found))
    assert len({tuple(svg.attrib["viewBox"].split()[2:]) for svg in svgs}) == 1
    for svg in svgs:
        left, top, wide, high = map(float, svg.attrib["viewBox"].split())
        wheels = svg.findall("circle")
        assert len(wheels) == len(found.scene.wheels)
        for wheel in wheels:
            assert left < float(wheel.attrib["cx"]) < left + wide
            assert top < float(wheel.attrib["cy"]) < top + high


def _svgs(text: str) -> list[str]:
    return [f"<svg{part.partition('</svg>')[0]}" for part in text.split("<svg")[1:]]


def test_what_holds_is_coloured(report: Reports) -> None:
    loose, *_, end = _svgs(strip(report("bend")))

    assert loose.count("held") == 0
    assert end.count("held") > 0


def test_where_nobody_knows_where_the_robot_was_there_is_no_strip(report: Reports) -> None:
    assert strip(report("trace")) == ""

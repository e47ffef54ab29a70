from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from pirate_sm.core import library
from pirate_sm.core.loading import load_pipe
from pirate_sm.views.drawing.pipe_plan import plan_svg

ROOT = Path(__file__).resolve().parents[4]
NUMBER = re.compile(r"-?[\d.]+")


def drawn(place: Path) -> ElementTree.Element:
    """The drawing of the pipe in a file."""
    pipe, _ = load_pipe(place)
    return ElementTree.fromstring(plan_svg(pipe, place.stem))


def texts(drawing: ElementTree.Element) -> list[str]:
    return [each.text or "" for each in drawing.iter() if each.tag.endswith("text")]


def paths(drawing: ElementTree.Element, kind: str) -> list[list[tuple[float, float]]]:
    """The corners of each path of this class."""
    found = [each.get("d") or "" for each in drawing.iter() if each.get("class") == kind]
    numbers = [[float(number) for number in NUMBER.findall(each)] for each in found]
    return [list(zip(each[::2], each[1::2], strict=True)) for each in numbers]


def long(points: list[tuple[float, float]], axis: int) -> float:
    return max(point[axis] for point in points) - min(point[axis] for point in points)


def test_a_plan_is_to_scale() -> None:
    place = library.find_pipe("straight_113", ROOT)
    pipe, _ = load_pipe(place)
    drawing = drawn(place)
    ruler, bore = paths(drawing, "ruler")[0], paths(drawing, "bore")[0]
    length = next(text for text in texts(drawing) if re.fullmatch(r"[\d.]+ c?m", text))
    value, unit = length.split()
    per_m = long(ruler, 0) / (float(value) / (100 if unit == "cm" else 1))

    assert long(bore, 0) == pytest.approx(pipe.route().length_m * per_m, rel=0.01)
    assert long(bore, 1) == pytest.approx(pipe.diameter * per_m, rel=0.02)


@pytest.mark.parametrize(
    ("pipe", "views"),
    [
        ("sequences/pipes/mitre_90.yaml", ["From above"]),
        ("tests/pipes/house.yaml", ["From above", "From the side"]),
    ],
)
def test_a_pipe_that_lies_in_a_plane_is_drawn_in_it_alone(pipe: str, views: list[str]) -> None:
    found = texts(drawn(ROOT / pipe))

    assert [each for each in found if each.startswith("From ")] == views
    assert "begins" in found
    assert "ends" in found
    assert any("mitre" in each or "elbow" in each or "tee" in each for each in found)

import re
from math import nan
from xml.etree import ElementTree

import pytest

from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries, plot_svg


def drawn(*series: PlotSeries, log_x: bool = False) -> str:
    return plot_svg(Plot("A < B", "time, s", "way, m", series, log_x=log_x))


def path_of(svg: str, look: str) -> str:
    found = re.search(rf'class="{look}"[^>]* d="([^"]*)"', svg)
    assert found is not None
    return found[1]


def test_it_is_well_formed_and_names_its_title_and_axes() -> None:
    svg = drawn(PlotSeries("one", [0, 1, 2], [0, 1, 4]))

    texts = [each.text for each in ElementTree.fromstring(svg).iter() if each.text]
    assert {"A < B", "time, s", "way, m", "one"} <= set(texts)


def test_a_line_goes_up_with_its_values() -> None:
    places = path_of(drawn(PlotSeries("", [0, 1], [0, 1])), "curve")[1:].split("L")
    (x1, y1), (x2, y2) = (map(float, place.split()) for place in places)

    assert x1 < x2
    assert y1 > y2


def test_unknown_values_and_those_off_a_logarithmic_axis_are_left_out() -> None:
    svg = drawn(PlotSeries("", [-1, 0, 1, 10, 100], [1, 1, nan, 2, 3], "dots"), log_x=True)

    assert path_of(svg, "dots").count("M") == 2


def test_a_band_is_closed() -> None:
    svg = drawn(PlotSeries("", [0, 1], [0, 0], "band", [1, 2]))

    assert path_of(svg, "band").endswith("Z")


@pytest.mark.parametrize("values", [[], [nan], [3.0]])
def test_a_plot_of_nothing_or_of_one_point_can_be_drawn(values: list[float]) -> None:
    ElementTree.fromstring(drawn(PlotSeries("", values, values)))


def test_very_many_points_are_thinned() -> None:
    count = 100_000
    svg = drawn(PlotSeries("", range(count), range(count)))

    assert len(path_of(svg, "curve").split("L")) <= 1500


def test_series_differ_in_more_than_their_colour() -> None:
    lines = [PlotSeries(f"line {n}", [0, 1], [n, n], colour=n) for n in range(4)]
    points = [PlotSeries(f"dots {n}", [0, 1], [n, n], "dots", colour=n) for n in range(4)]
    svg = drawn(*lines, *points)

    dashes = re.findall(r'class="curve" style="stroke:var\(--curve\d\);?([^"]*)"', svg)
    marks = re.findall(r'class="dots" [^>]* d="M[0-9. ]+([a-z][^M"]*)', svg)
    assert len(set(dashes)) == 4
    assert len({each.removeprefix("m12 0") for each in marks}) == 4
    assert svg.count('class="sample"') == 4

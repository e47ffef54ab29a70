from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries
from pirate_sm.views.report.figure_page import FigureSection, figure_page


def test_words_tables_and_plots_stand_in_one_file_that_loads_no_other() -> None:
    plot = Plot("way", "s", "m", (PlotSeries("", [0, 1], [0, 1]),))

    page = figure_page("A & B", [FigureSection("One", ["<b>"], ("x",), [("1 < 2",)], [plot])])

    assert "<title>A &amp; B</title>" in page
    assert "<p>&lt;b&gt;</p>" in page
    assert "<td>1 &lt; 2</td>" in page
    assert '<svg class="plot"' in page
    assert "default-src 'none'" in page
    assert "src=" not in page.replace("-src", "")
    assert "http://" not in page
    assert "https://" not in page

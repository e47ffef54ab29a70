from __future__ import annotations

from pathlib import Path

from representative import MISSIONS as REPRESENTATIVE

from pirate_sm.core.documents import Problems, parse_document, read_document
from pirate_sm.core.loading import ChartOutline, outline_chart, validate
from pirate_sm.core.models import Mission
from pirate_sm.views.drawing.graph.graph import Graph, chart_graph
from pirate_sm.views.drawing.graph.mission_graph import called_missions, mission_graph

ROOT = Path(__file__).resolve().parents[4]
MISSIONS = sorted(
    [
        *ROOT.glob("sequences/*.yaml"),
        *ROOT.glob("docs/examples/*.yaml"),
        ROOT / "tests/robots/newt/patrol.yaml",
    ]
)
CHARTS = [
    ROOT / "hardware_profiles" / "pirate_ii" / "chart.yaml",
    ROOT / "tests/robots/newt/chart.yaml",
]
DRAWN = [*MISSIONS, *CHARTS]
FEW = [path for path in DRAWN if path.parent.name != "sequences" or path.stem in REPRESENTATIVE]


def name(path: Path) -> str:
    return f"{path.parent.name}-{path.stem}"


def read_mission(path: Path) -> Mission:
    return validate(read_document(path), Mission)


def read_chart(path: Path) -> ChartOutline:
    document = read_document(path)
    outline = outline_chart(document, Problems(document))
    assert outline is not None
    return outline


def drawing(path: Path) -> Graph:
    """The graph of a shipped file; a mission with those that it calls."""
    if path in CHARTS:
        return chart_graph(read_chart(path), path.parent.name)
    mission = read_mission(path)
    return mission_graph(mission, called_missions(mission, path))


def written(phases: str, more: str = "", ends: str = "ends: {well: {succeed: Well}}") -> Mission:
    """A mission with these phases, of which the first is `a`."""
    text = f"format: 1\nmission: tiny\nrobot: none\nstart: a\n{more}\nphases:\n{phases}\n{ends}\n"
    return validate(parse_document(text, "tiny.yaml"), Mission)

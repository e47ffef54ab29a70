from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from .conftest import NEWT, ROOT

CHART = ROOT / "hardware_profiles" / "pirate_ii" / "chart.yaml"


@pytest.mark.parametrize(
    "what", ["mitre_bend", "pirate_ii", NEWT, NEWT / "profile.yaml", NEWT / "patrol.yaml", CHART]
)
@pytest.mark.parametrize(
    ("kind", "begins"), [("mermaid", "---"), ("dot", "digraph"), ("svg", "<svg")]
)
def test_missions_robots_and_charts_are_drawn(
    pirate: Any, what: Any, kind: str, begins: str
) -> None:
    result = pirate("graph", what, "--format", kind)

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith(begins)


@pytest.mark.parametrize(
    ("name", "begins"), [("a.svg", "<svg"), ("a.gv", "digraph"), ("a.mmd", "---"), ("a", "---")]
)
def test_the_output_names_the_format(pirate: Any, name: str, begins: str, tmp_path: Path) -> None:
    assert pirate("graph", "climb", "-o", tmp_path / name).exit_code == 0
    assert (tmp_path / name).read_text("utf-8").startswith(begins)


def test_a_path_is_marked(pirate: Any) -> None:
    result = pirate("graph", "climb", "--format", "svg", "--highlight", "up, holding,slipped,")

    classes = [each.get("class") for each in ElementTree.fromstring(result.stdout).iter()]
    assert classes.count("phase visited") == 2
    assert classes.count("fail visited") == 1


def test_called_missions_are_drawn_when_asked_for(pirate: Any) -> None:
    assert "subgraph" not in pirate("graph", "mitre_bend").stdout
    assert pirate("graph", "mitre_bend", "--calls").stdout.count("subgraph") == 2


def test_what_is_wrong_with_a_mission_is_told_with_its_place(pirate: Any, tmp_path: Path) -> None:
    text = (ROOT / "sequences" / "climb.yaml").read_text("utf-8")
    mission = tmp_path / "wrong.yaml"
    mission.write_text(text.replace("go: holding", "go: holdin"), encoding="utf-8")
    result = pirate("graph", mission)

    assert result.exit_code == 2
    assert result.stdout == ""
    assert "wrong.yaml:" in result.stderr
    assert "did you mean 'holding'?" in result.stderr


def test_what_is_wrong_with_a_chart_is_told_with_its_place(pirate: Any, tmp_path: Path) -> None:
    chart = tmp_path / "chart.yaml"
    chart.write_text("states: {robot: {}}\n", encoding="utf-8")
    result = pirate("graph", chart)

    assert result.exit_code == 2
    assert "chart.yaml:1" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["mitre_bnd"], "did you mean 'mitre_bend'?"),
        (["nothing/of/this/name.yaml"], "nothing/of/this/name.yaml"),
        (["climb", "--highlight", "upp"], "did you mean 'up'?"),
        (["climb", "--set", "height"], "expected NAME=VALUE"),
        (["climb", "-o", "no/such/folder/a.svg"], "cannot be written"),
        ([ROOT / "sequences" / "pipes" / "mitre_90.yaml"], "is a pipe"),
        ([ROOT / "sequences"], "there is no robot"),
    ],
)
def test_misuse_is_told_in_a_line(pirate: Any, arguments: list[Any], says: str) -> None:
    result = pirate("graph", *arguments)

    assert (result.exit_code, result.stdout) == (2, "")
    assert says in result.stderr

"""Charts as SCXML: python-statemachine opens them, and what they allow is what the engine allows.

The reader of python-statemachine knows nothing of this package.
"""

from __future__ import annotations

import ast
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.core.documents import parse_document
from pirate_sm.core.loading import ChartOutline, LoadedRobot, load_robot
from pirate_sm.core.robot import ChartTable
from pirate_sm.views.interchange.scxml import chart_scxml
from pirate_sm.views.interchange.scxml_chart_reader import chart_text, read_chart

from .charts import COMMANDS, ROBOTS, Reread, charts, outline_of, outlined, table_of


@pytest.fixture(scope="module", params=ROBOTS, ids=lambda folder: folder.name)
def robot(request: pytest.FixtureRequest) -> LoadedRobot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def scxml(robot: LoadedRobot) -> str:
    return chart_scxml(outlined(robot.documents[1]), robot.profile.robot)


def expected(table: ChartTable, commands: list[str]) -> list[tuple[str, ...]]:
    """Return the states of the regions after each command, by the engine's table."""
    found, at = [], table.initial
    for command in commands:
        at = table.following[at][table.commands.index(command)]
        found.append(table.configurations[at])
    return found


def meaning(outline: ChartOutline) -> Any:
    """Return all that an outline says, with guards as their normal text."""
    moves = [
        (each.source, each.owner, each.event, each.target, each.guard and normal(each.guard))
        for each in outline.transitions
    ]
    nodes = [
        (node.name, node.initial) for top in outline.nodes for each in top for node in each.walk()
    ]
    return outline.regions, outline.states, outline.initial, outline.commands, moves, nodes


def normal(guard: str) -> str:
    return ast.unparse(ast.parse(guard, mode="eval"))


@settings(max_examples=6)
@given(data=st.data())
def test_a_command_sequence_of_a_robot_has_the_same_effect(
    robot: LoadedRobot, scxml: str, data: st.DataObject
) -> None:
    table = robot.normal.table
    commands = data.draw(st.lists(st.sampled_from(table.commands), min_size=30, max_size=60))

    assert Reread(scxml).follow(commands, table.regions) == expected(table, commands)


@pytest.mark.slow
def test_every_command_in_every_configuration_of_a_robot_has_the_same_effect(
    robot: LoadedRobot, scxml: str
) -> None:
    from statemachine.orderedset import OrderedSet  # noqa: PLC0415

    table, reread = robot.normal.table, Reread(scxml)
    active = {0: tuple(reread.machine.configuration_values)}
    for index in (order := [0]):
        for command, reached in zip(table.commands, table.following[index], strict=True):
            reread.machine.current_state_value = OrderedSet(active[index])
            assert reread.follow([command], table.regions) == [table.configurations[reached]]
            if reached not in active:
                active[reached] = tuple(reread.machine.configuration_values)
                order.append(reached)
    assert len(order) == len(table.configurations)


@pytest.mark.thorough
@settings(max_examples=40)
@given(charts(), st.lists(st.sampled_from(COMMANDS), max_size=12))
def test_a_command_sequence_of_any_chart_has_the_same_effect(
    data: dict[str, Any], commands: list[str]
) -> None:
    table = table_of(data)
    known = [each for each in commands if each in table.commands]
    scxml = chart_scxml(outline_of(data), "drawn")

    assert Reread(scxml).follow(known, table.regions) == expected(table, known)


def test_the_chart_of_a_robot_comes_back(robot: LoadedRobot, scxml: str) -> None:
    document, outline = read_chart(scxml, "robot.scxml", "robot")
    written = parse_document(chart_text(document.data, "robot.scxml"), "chart.yaml")

    before = outlined(robot.documents[1])
    assert meaning(outline) == meaning(before)
    assert meaning(outlined(written)) == meaning(before)


@settings(max_examples=40)
@given(charts())
def test_any_chart_comes_back(data: dict[str, Any]) -> None:
    before = outline_of(data)

    document, outline = read_chart(chart_scxml(before, "drawn"), "drawn.scxml", "")
    written = parse_document(chart_text(document.data, "drawn.scxml"), "chart.yaml")

    assert meaning(outline) == meaning(before)
    assert meaning(outlined(written)) == meaning(before)
    assert written.data == document.data


@pytest.mark.parametrize("top", ["my robot", "Lamp"])
def test_a_name_that_cannot_be_an_id_is_replaced(top: str) -> None:
    data = {
        "states": {
            top: {"parallel": True, "states": {"Lamp": {"states": {"Lamp.On": {"initial": True}}}}}
        }
    }

    scxml = chart_scxml(outline_of(data), "a lamp", "On & <on>")

    document, _ = read_chart(scxml, "lamp.scxml", "")
    assert list(document.data["states"]) == ["all.regions"]
    assert (document.data["name"], document.data["description"]) == ("a_lamp", "On & <on>")
    assert Reread(scxml).machine.configuration_values == {"all.regions", "Lamp", "Lamp.On"}

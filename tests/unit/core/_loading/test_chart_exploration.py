"""The library's semantics, kept in a table; and what the library accepts and we do not."""

from __future__ import annotations

import json
import shutil
from collections import deque
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from representative import thorough_but
from statemachine import StateChart
from statemachine.io import load as library_load
from statemachine.orderedset import OrderedSet

from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading import chart_exploration as chart_cache
from pirate_sm.core._loading.chart_exploration import cached_table, compile_chart
from pirate_sm.core._loading.chart_outline import outline_chart
from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._loading.yaml.document import parse_document, read_document
from pirate_sm.core.kept_entries import Entries, _signature
from pirate_sm.core.on_disk import noting

ROOT = Path(__file__).resolve().parents[4]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"
HELD = "{event: HoldTail, target: Grip.BothHeld, cond: \"In('Crawl.Resting')\"}"
FIRST = "{event: HoldNose, target: Grip.NoseHeld}"


def table_of(robot: Path) -> ChartTable:
    document = read_document(robot / "chart.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None, problems.all
    return cached_table(document, outline, problems)


def library_machine(robot: Path):
    """The chart as the library reads it by itself."""
    return library_load(robot / "chart.yaml")


def reached(machine, table: ChartTable) -> tuple[str, ...]:
    by_region = dict(value.split(".", 1) for value in machine.configuration_values if "." in value)
    return tuple(by_region[region] for region in table.regions)


def values(table: ChartTable, configuration: int, top: str) -> OrderedSet:
    states = zip(table.regions, table.configurations[configuration], strict=True)
    pairs = [(region, f"{region}.{state}") for region, state in states]
    return OrderedSet([top, *(value for pair in pairs for value in pair)])


def test_the_chart_of_the_shipped_robot_reaches_what_the_decisions_say():
    table = table_of(PIRATE)

    assert len(table.commands) == 14
    assert len(table.configurations) == 176
    pairs = [(here, there) for here, row in enumerate(table.following) for there in row]
    assert len(pairs) == 2464
    assert sum(here != there for here, there in pairs) == 1173


@pytest.mark.parametrize("robot", thorough_but([NEWT], [PIRATE, NEWT]), ids=["pirate_ii", "newt"])
def test_every_pair_through_the_library_and_through_the_table(robot):
    table = table_of(robot)
    machine = library_machine(robot)()
    top = next(value for value in machine.configuration_values if "." not in value)
    assert reached(machine, table) == table.configurations[table.initial]

    for here in range(len(table.configurations)):
        for number, command in enumerate(table.commands):
            machine.current_state_value = values(table, here, top)
            machine.send(command)
            there = table.configurations[table.follow(here, number)]
            assert reached(machine, table) == there, (table.configurations[here], command)


@pytest.mark.parametrize("robot", thorough_but([NEWT], [PIRATE, NEWT]), ids=["pirate_ii", "newt"])
def test_every_configuration_is_reached_by_commands_from_the_start(robot):
    table = table_of(robot)
    chart = library_machine(robot)
    paths: dict[int, tuple[str, ...]] = {table.initial: ()}
    queue = deque([table.initial])
    while queue:
        here = queue.popleft()
        for number, command in enumerate(table.commands):
            there = table.follow(here, number)
            if there not in paths:
                paths[there] = (*paths[here], command)
                queue.append(there)

    assert len(paths) == len(table.configurations)
    for configuration, path in paths.items():
        machine = chart()
        for command in path:
            machine.send(command)
        assert reached(machine, table) == table.configurations[configuration]


def test_a_reason_is_given_exactly_where_the_chart_does_not_move():
    table = table_of(PIRATE)

    for here, row in enumerate(table.following):
        for number, there in enumerate(row):
            assert bool(table.why_not(here, number)) == (here == there)


def test_a_configuration_that_cannot_be_reached_has_no_index():
    table = table_of(PIRATE)

    assert table.index_of(("DrivingForward", "Free", "Unclamped", "Unaligned", "Off")) is None
    assert table.index_of(table.configurations[7]) == 7


def test_names_that_older_yaml_takes_for_booleans_are_names(tmp_path):
    robot = tmp_path / "newt"
    shutil.copytree(NEWT, robot)
    for file in ("chart.yaml", "profile.yaml"):
        text = (robot / file).read_text("utf-8")
        (robot / file).write_text(text.replace("SwitchLamp", "on").replace("Lit", "On"), "utf-8")

    table = load_robot(robot).table

    assert "on" in table.commands
    assert "On" in table.states[2]
    assert len(table.configurations) == 20


@pytest.mark.parametrize(
    ("guard", "message"),
    [
        ("In(Crawl)", "In(Crawl) is always true without quotes; write In('Crawl')"),
        (
            "In(Crawl.Resting)",
            "In(Crawl.Resting) is always true without quotes; write In('Crawl.Resting')",
        ),
        ("In('Crawl.Restin')", "there is no state 'Crawl.Restin'"),
        ("In('Resting')", "there is no state 'Resting'"),
        ("not In(('Nowhere'))", "there is no state 'Nowhere'"),
        ("In('Crawl.Resting') and", "this guard cannot be read"),
        *(
            (guard, "a guard may only use In('Region.State'), and, or, not, and parentheses")
            for guard in (
                "In()", "In", "foo", "True", "1", "foo('x')", "In('Crawl.Resting', 'Lamp.Lit')",
                "In('Crawl.Resting').__class__", "In(state='Crawl.Resting')", "[]",
                "In('Crawl.Resting') == True", "In('Crawl.Resting') or x",
                "__import__('os').system('true')", "lambda: 1",
            )
        ),
    ],
)  # fmt: skip
def test_a_guard_that_would_always_be_true_is_refused_with_its_place(newt, guard, message):
    quoted = f'{{event: HoldTail, target: Grip.BothHeld, cond: "{guard}"}}'

    assert newt("chart.yaml", (HELD, quoted)) == [f"chart.yaml:17:64: {message}"]


@pytest.mark.parametrize("guard", ["true", "5", "[a]", "''", "{}"])
def test_a_guard_that_is_no_text_is_refused(newt, guard):
    changed = f"{{event: HoldTail, target: Grip.BothHeld, cond: {guard}}}"

    assert newt("chart.yaml", (HELD, changed)) == ["chart.yaml:17:64: `cond` must be text"]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (FIRST, "{event: HoldNose}", "13:17: a transition needs `event` and `target`"),
        (FIRST, "{target: Grip.NoseHeld}", "13:17: a transition needs `event` and `target`"),
        (FIRST, "HoldNose", "13:17: a transition needs `event` and `target`"),
        (FIRST, "{event: HoldNose, target: Grip.Nosed}", "13:43: there is no state 'Grip.Nosed'"),
        (FIRST, "{event: HoldNose, target: Lamp.Lit}", "13:43: a transition of Grip must stay in"),
        (FIRST, "{event: HoldNose, target: [a]}", "13:43: `target` must be text"),
        (FIRST, "{event: [], target: Grip.NoseHeld}", "13:25: `event` must be text, or a list"),
        (FIRST, "{event: [A, 5], target: Grip.NoseHeld}", "13:29: an event is named by letters"),
        (FIRST, "{event: [A B], target: Grip.NoseHeld}", "13:26: an event is named by letters"),
        (FIRST, "{event: , target: Grip.NoseHeld}", "13:25: `event` must be text"),
        (FIRST, "{event: '*', target: Grip.NoseHeld}", "13:25: an event is named by letters"),
        (FIRST, "{event: A-B, target: Grip.NoseHeld}", "13:25: an event is named by letters"),
        ("Grip.NoseHeld:\n", "Grip.NoseHeld:\n            states: {}\n",
         "16:21: a state with `states` has"),
        ("Grip.NoseHeld:\n", "Grip.NoseHeld:\n            states: {Grip.A: {}, Grip.B: {}}\n",
         "15:11: Grip.NoseHeld needs exactly one `initial: true`"),
        ("Grip.NoseHeld:\n",
         "Grip.NoseHeld:\n            states: {Grip.Loose: {initial: true}}\n",
         "8:7: a state of Grip stands twice: 'Grip.Loose'"),
        ("Grip.NoseHeld:\n", "Grip.NoseHeld:\n            history: {}\n", "16:13: 'history' is"),
        (FIRST, "{event: HoldNose, target: Grip.NoseHeld, on: x}", "13:58: 'on' is known in"),
        ("transitions:", "transitons:", "12:13: unknown key 'transitons'"),
        ("            initial: true\n", "", "8:7: Grip needs exactly one `initial: true`"),
        ("initial: true", "initial: yes", "8:7: Grip needs exactly one `initial: true`"),
        (
            "Grip.NoseHeld:\n",
            "Grip.NoseHeld:\n            initial: true\n",
            "8:7: Grip needs exactly one",
        ),
        ("Grip.NoseHeld:\n", "NoseHeld:\n", "15:11: a state of Grip is named `Grip.<State>`"),
        ("Grip.NoseHeld:\n", "Grip.x:\n            final: true\n", "16:13: 'final' is"),
        ("Grip.NoseHeld:\n", "Grip.x:\n            enter: rm\n", "16:13: 'enter' is"),
        ("          Grip.NoseHeld:\n", "          Grip.x: 5\n          Grip.NoseHeld:\n",
         "15:19: a state has `initial`, `transitions`"),
        ("    parallel: true\n", "", "5:3: the chart's one state needs `parallel: true`"),
        ("states:\n  newt:", "states:\n  other: {}\n  newt:", "2:1: a chart has `states` with"),
        ("name: newt", "nam: newt", "2:1: unknown key 'nam'"),
        ("name: newt", "datamodel: {x: 1}", "2:1: 'datamodel' is known in"),
        ("      Lamp:\n", "      Empty: {}\n      Lamp:\n", "43:7: a region needs `states`"),
        ("      Lamp:\n", "      detector: {states: {detector.A: {initial: true}}}\n      Lamp:\n",
         "43:7: 'detector' means something else in conditions"),
        ("      Lamp:\n", "      mm: {states: {mm.A: {initial: true}}}\n      Lamp:\n",
         "43:7: 'mm' cannot be the name of a signal: it is a unit"),
        ("          Grip.NoseHeld:", "          Grip.Loose: {}\n          Grip.NoseHeld:",
         "15:11: the key 'Grip.Loose' appears twice"),
    ],
)  # fmt: skip
def test_a_fault_of_the_chart_is_told_with_its_place(newt, old, new, fault):
    said = newt("chart.yaml", (old, new))

    assert any(each.startswith(f"chart.yaml:{fault}") for each in said), said


@pytest.mark.parametrize("listed", ["5", "abc", "{a: b}"])
def test_transitions_are_a_list(newt, listed):
    old = """            transitions:
              - {event: HoldNose, target: Grip.NoseHeld}
              - {event: HoldTail, target: Grip.TailHeld}"""

    said = newt("chart.yaml", (old, f"            transitions: {listed}"))

    assert "chart.yaml:12:26: expected a list of transitions" in said


def test_a_misspelt_event_is_one_that_the_profile_does_not_know(newt):
    said = newt("chart.yaml", (FIRST, "{event: HoldNoze, target: Grip.NoseHeld}"))

    (fault,) = said
    assert fault.startswith("profile.yaml:")
    assert fault.endswith("the chart's event 'HoldNoze' is missing here")


def test_a_state_that_no_commands_lead_to_is_refused(tmp_path):
    robot = tmp_path / "newt"
    shutil.copytree(NEWT, robot)
    lost, held = "    Lost: {fold_neck: 0 %, fold_hip: 0 %}\n", "    NoseHeld: {f"
    state = "          Grip.NoseHeld:"
    for file, old, new in (
        ("chart.yaml", state, f"          Grip.Lost: {{}}\n{state}"),
        ("profile.yaml", held, lost + held),
    ):
        text = (robot / file).read_text("utf-8")
        (robot / file).write_text(text.replace(old, new, 1), "utf-8")

    with pytest.raises(LoadError, match=r"chart\.yaml:15:11: no commands lead to Grip\.Lost"):
        load_robot(robot)


@pytest.mark.parametrize("word", ["send", "configuration", "name", "current_state_value", "newt"])
def test_names_may_be_words_of_the_library(tmp_path, word):
    usual = load_robot(NEWT).table
    robot = tmp_path / "newt"
    shutil.copytree(NEWT, robot)
    for file in ("chart.yaml", "profile.yaml"):
        text = (robot / file).read_text("utf-8")
        text = text.replace("SwitchLamp", word).replace("Crawl", f"{word}_")
        (robot / file).write_text(text.replace("  newt:\n", f"  {word}:\n"), "utf-8")

    table = load_robot(robot).table

    assert table.configurations == usual.configurations
    assert table.following == usual.following


def ring(count: int) -> dict[str, object]:
    """A region of states in a ring, each with its own command to the next."""
    return {
        f"R.S{n}": {
            "initial": n == 0,
            "transitions": [{"event": f"go{n}", "target": f"R.S{(n + 1) % count}"}],
        }
        for n in range(count)
    }


@pytest.mark.parametrize(("most", "is_refused"), [(900, False), (899, True)])
def test_the_library_is_asked_only_for_commands_that_have_a_transition(
    monkeypatch, most: int, is_refused: bool
) -> None:
    monkeypatch.setattr("pirate_sm.core._loading.chart_exploration.MOST_RESULTS", most)
    asked: list[str] = []
    send = StateChart.send
    monkeypatch.setattr(
        StateChart, "send", lambda it, event: (asked.append(event), send(it, event))[1]
    )
    regions = {"R": {"states": ring(30)}}
    text = json.dumps({"name": "ring", "states": {"top": {"parallel": True, "states": regions}}})
    document = parse_document(text, "ring.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None

    if is_refused:
        with pytest.raises(LoadError, match="more than 29 combinations of states with 30 commands"):
            compile_chart(document, outline, problems)
        return
    table = compile_chart(document, outline, problems)
    assert len(asked) == 30
    assert len(table.configurations) == 30
    assert table.following[3] == tuple(4 if command == "go3" else 3 for command in table.commands)


def test_a_chart_that_is_too_large_is_refused(monkeypatch):
    monkeypatch.setattr("pirate_sm.core._loading.chart_exploration.MOST_CONFIGURATIONS", 100)
    count = 7  # 2 ** 7 combinations
    regions = {
        f"R{n}": {
            "states": {
                f"R{n}.A": {
                    "initial": True,
                    "transitions": [{"event": f"go{n}", "target": f"R{n}.B"}],
                },
                f"R{n}.B": {},
            }
        }
        for n in range(count)
    }
    text = json.dumps({"name": "wide", "states": {"top": {"parallel": True, "states": regions}}})
    document = parse_document(text, "wide.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None

    with pytest.raises(LoadError, match="more than 100 combinations"):
        cached_table(document, outline, problems)


# --- compound states and several events


def moving_newt(folder: Path, moving: str) -> Path:
    """A newt whose states of moving ahead and astern are written otherwise."""
    robot = folder / "newt"
    shutil.copytree(NEWT, robot)
    text = (robot / "chart.yaml").read_text("utf-8")
    begin, end = text.index("          Crawl.Ahead:\n"), text.index("      Lamp:\n")
    (robot / "chart.yaml").write_text(text[:begin] + moving + text[end:], "utf-8")
    return robot


def test_a_compound_state_comes_to_the_table_of_its_states_written_one_by_one(tmp_path):
    usual = load_robot(NEWT).table
    moving = """\
          Crawl.Moving:
            transitions: [{event: Rest Home, target: Crawl.Resting}]
            states:
              Crawl.Ahead: {initial: true}
              Crawl.Astern: {}
"""

    table = load_robot(moving_newt(tmp_path, moving)).table

    assert table.states == usual.states
    assert table.configurations == usual.configurations
    assert set(table.commands) == set(usual.commands)
    for here in range(len(usual.configurations)):
        for number, command in enumerate(usual.commands):
            there = table.follow(here, table.command_index[command])
            assert there == usual.follow(here, number)


REGIONS = "PQ"
SHAPES = [
    ["a", "b"],
    ["a", ["b", "c", "d"]],
    [["a", "b", "c"], ["d", "e", "f"]],
    ["a", ["b", ["c", "d", "e"], "f"]],
]  # a list is a compound state, named by its first
EVENTS = st.sampled_from(["x", "y", "z", "x y", ["y", "z"], ["x"]])


def names(shape, region: str):
    """Every state of a shape, compound ones too."""
    for each in shape:
        if isinstance(each, list):
            yield f"{region}.{each[0]}"
            yield from names(each[1:], region)
        else:
            yield f"{region}.{each}"


@st.composite
def charts(draw):
    """A chart of two regions, some of whose states have others inside."""
    shapes = {region: draw(st.sampled_from(SHAPES)) for region in REGIONS}
    known = {region: list(names(shape, region)) for region, shape in shapes.items()}
    anything = st.sampled_from([name for each in known.values() for name in each])

    def move(region):
        found = {"event": draw(EVENTS), "target": draw(st.sampled_from(known[region]))}
        guard = draw(st.sampled_from(["", "In('{}')", "not In('{}')"])).format(draw(anything))
        return {**found, "cond": guard} if guard else found

    def state(each, region, initial):
        name, inner = (each[0], each[1:]) if isinstance(each, list) else (each, [])
        moves = [move(region) for _ in range(draw(st.integers(0, 3)))]
        body = {"initial": initial, "transitions": moves}
        return f"{region}.{name}", {**body, "states": states(inner, region)} if inner else body

    def states(shape, region):
        first = draw(st.integers(0, len(shape) - 1))
        return dict(state(each, region, n == first) for n, each in enumerate(shape))

    regions = {region: {"states": states(shape, region)} for region, shape in shapes.items()}
    return {"name": "any", "states": {"top": {"parallel": True, "states": regions}}}


@pytest.mark.thorough
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(charts())
def test_compound_states_do_in_the_table_what_they_do_in_the_library(chart):
    text = json.dumps(chart)
    document = parse_document(text, "chart.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None, problems.all
    if not outline.transitions:
        return  # the library refuses a chart in which nothing happens
    table = compile_chart(document, outline, problems)
    machine = library_load(text, format="json")
    leaves = {
        f"{r}.{s}" for r, states in zip(table.regions, table.states, strict=True) for s in states
    }
    paths = {table.initial: ()}
    queue = deque([table.initial])
    while queue:
        here = queue.popleft()
        for number, command in enumerate(table.commands):
            played = machine()
            for each in (*paths[here], command):
                played.send(each)
            there = table.follow(here, number)
            active = leaves & set(played.configuration_values)
            states = zip(table.regions, table.configurations[there], strict=True)
            assert active == {f"{region}.{state}" for region, state in states}
            if there not in paths:
                paths[there] = (*paths[here], command)
                queue.append(there)
    assert len(paths) == len(table.configurations)


def test_a_command_is_refused_with_the_states_that_a_compound_one_stands_for(tmp_path):
    moving = """\
          Crawl.Moving:
            transitions: [{event: [Rest, Home], target: Crawl.Resting}]
            states: {Crawl.Ahead: {initial: true}, Crawl.Astern: {}}
"""
    robot = moving_newt(tmp_path, moving)
    chart = (robot / "chart.yaml").read_text("utf-8")
    chart = chart.replace("In('Crawl.Resting')", "not In('Crawl.Moving')")
    (robot / "chart.yaml").write_text(chart, "utf-8")

    table = load_robot(robot).table

    here = table.index_of(("NoseHeld", "Ahead", "Dark"))
    assert table.why_not(here, table.command_index["HoldTail"]) == (
        "it needs not Crawl in (Ahead, Astern)"
    )
    at_rest = table.index_of(("Loose", "Resting", "Dark"))
    assert table.why_not(at_rest, table.command_index["Rest"]) == (
        "it needs Crawl in (Ahead, Astern)"
    )


# --- the cache


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setattr(chart_cache, "charts", lambda: Entries(folder))
    return folder


def test_the_second_time_the_library_is_not_needed(fresh_cache, monkeypatch):
    first = table_of(NEWT)
    monkeypatch.setattr(chart_cache, "compile_chart", None)

    assert table_of(NEWT) == first


@pytest.mark.parametrize(
    "spoil",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: content.replace(b'"Resting"', b'"Restless"'),
        lambda content: content.replace(b"[[0", b"[[1"),
    ],
)
def test_a_table_that_is_damaged_is_made_again(fresh_cache, spoil):
    right = table_of(NEWT)
    (file,) = fresh_cache.iterdir()
    whole = file.read_bytes()
    file.write_bytes(spoil(whole))
    assert file.read_bytes() != whole

    assert table_of(NEWT) == right
    assert file.read_bytes() == whole


@pytest.mark.parametrize(
    "content", [b"[" * 100_000, b"[]", b"{}", b"5", b'{"regions": 5}', b"\xed"]
)
def test_an_entry_that_is_no_table_is_done_without(fresh_cache, content):
    right = table_of(NEWT)
    (file,) = fresh_cache.iterdir()
    file.write_bytes(_signature(file.name, content) + b"\n" + content)

    assert table_of(NEWT) == right


def test_the_table_of_another_chart_is_not_taken(fresh_cache):
    table_of(PIRATE)
    (other,) = fresh_cache.iterdir()
    right = table_of(NEWT)
    (file,) = set(fresh_cache.iterdir()) - {other}
    shutil.copy(other, file)

    assert table_of(NEWT) == right


def test_tables_are_kept_in_a_folder_that_is_closed_to_others(fresh_cache):
    right = table_of(NEWT)
    assert fresh_cache.stat().st_mode & 0o777 == 0o700
    (file,) = fresh_cache.iterdir()
    file.write_bytes(b"")
    fresh_cache.chmod(0o755)

    assert table_of(NEWT) == right
    assert file.read_bytes() == b""


def test_whether_a_table_was_kept_is_no_question_of_a_check(fresh_cache):
    with noting() as first:
        table_of(NEWT)
    with noting() as second:
        table_of(NEWT)

    assert first.answers == second.answers


def test_a_cache_that_cannot_be_written_is_done_without(fresh_cache, monkeypatch, tmp_path):
    right = table_of(NEWT)
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setattr(chart_cache, "charts", lambda: Entries(blocked / "cache"))

    assert table_of(NEWT) == right


def test_another_text_has_another_table(tmp_path):
    table_of(NEWT)
    robot = tmp_path / "newt"
    shutil.copytree(NEWT, robot)
    chart = robot / "chart.yaml"
    chart.write_text(
        chart.read_text("utf-8").replace(", cond: \"In('Crawl.Resting')\"", ""), "utf-8"
    )

    assert table_of(robot) != table_of(NEWT)


def test_the_share_that_is_explored_is_shown_for_each_configuration() -> None:
    document = read_document(NEWT / "chart.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None
    shares: list[float] = []

    table = compile_chart(document, outline, problems, shares.append)

    assert len(shares) == len(table.configurations)
    assert 0.0 < shares[0] <= shares[-1] == 1.0

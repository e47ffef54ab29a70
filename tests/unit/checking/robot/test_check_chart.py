"""Each fault of a chart that loads is told once, at its own place; sound charts are left alone."""

from __future__ import annotations

import ast
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.checking.robot import robot_view as guards
from pirate_sm.checking.robot.check_chart import check_chart, examine
from pirate_sm.checking.robot.check_robot import check_robot
from pirate_sm.core._loading.chart_exploration import compile_chart
from pirate_sm.core.documents import Problems, parse_document
from pirate_sm.core.loading import load_robot, outline_chart

from ..robots import NEWT, PIRATE, changed, told

AHEAD = "{event: GoAhead, target: Crawl.Ahead, cond: \"not In('Grip.Loose')\"}"
TAIL_FIRST = "{event: HoldNose, target: Grip.BothHeld, cond: \"In('Crawl.Resting')\"}"
LIT = "{event: SwitchLamp, target: Lamp.Lit}"


def ahead(guard: str) -> tuple[str, str]:
    return AHEAD, AHEAD.replace("not In('Grip.Loose')", guard)


def nose(guard: str) -> tuple[str, str]:
    return TAIL_FIRST, TAIL_FIRST.replace("In('Crawl.Resting')", guard)


@pytest.mark.parametrize("robot", [NEWT, PIRATE], ids=lambda path: path.name)
def test_a_shipped_chart_has_no_finding(robot: Path) -> None:
    assert check_chart(load_robot(robot)) == ()


FAULTS = {
    "a tautology": (ahead("In('Grip.Loose') or not In('Grip.Loose')"),
                    "chart.guard_always", "In('Grip.Loose') or not"),
    "every state of a region": (nose("In('Lamp.Dark') or In('Lamp.Lit')"),
                                "chart.guard_always", "In('Lamp.Dark') or"),
    "its own state": (ahead("In('Crawl.Resting')"), "chart.guard_always", "In('Crawl.Resting')"),
    "a part that is always true": (
        ahead("not In('Grip.Loose') and (In('Lamp.Lit') or not In('Lamp.Lit'))"),
        "chart.guard_always", "In('Lamp.Lit') or not",
    ),
    "two states of a region at once": (
        nose("In('Crawl.Resting') and In('Crawl.Ahead')"),
        "chart.guard_never", "In('Crawl.Resting') and In('Crawl.Ahead')",
    ),
    "another state of its own region": (nose("In('Grip.NoseHeld')"),
                                        "chart.guard_never", "In('Grip.NoseHeld')"),
    "a part that is never true": (
        nose("In('Crawl.Resting') or (In('Lamp.Lit') and In('Lamp.Dark'))"),
        "chart.guard_never", "In('Lamp.Lit') and In('Lamp.Dark')",
    ),
    "a combination that is not reached": (
        ("- {event: Rest, target: Crawl.Resting}",
         "- {event: Rest, target: Crawl.Resting}\n"
         "              - {event: GoAstern, target: Crawl.Astern, cond: \"In('Grip.Loose')\"}"),
        "chart.transition_never", "In('Grip.Loose')",
    ),
    "one of several conditions that is never so": (
        ("- {event: Rest, target: Crawl.Resting}",
         "- {event: Rest, target: Crawl.Resting}\n              - event: GoAstern\n"
         "                target: Crawl.Astern\n                cond: >-\n"
         "                  In('Lamp.Lit')\n                  and In('Grip.Loose')"),
        "chart.transition_never", "In('Grip.Loose')",
    ),
    "the same transition twice": (
        (f"- {LIT}", f"- {LIT}\n              - {LIT}"), "chart.transition_never", "SwitchLamp",
    ),
    "two targets without a guard": (
        ("- {event: Home, target: Grip.Loose}",
         "- {event: Home, target: Grip.Loose}\n"
         "              - {event: Home, target: Grip.TailHeld}"),
        "chart.ambiguous", "Home, target: Grip.TailHeld",
    ),
    "two targets whose guards overlap": (
        (f"- {TAIL_FIRST}",
         f"- {TAIL_FIRST}\n"
         "              - {event: HoldNose, target: Grip.NoseHeld, cond: \"In('Lamp.Lit')\"}"),
        "chart.ambiguous", "HoldNose, target: Grip.NoseHeld",
    ),
    "a state that is never left": (
        ("          Lamp.Lit:\n            transitions:\n"
         "              - {event: SwitchLamp, target: Lamp.Dark}\n"
         "              - {event: Home, target: Lamp.Dark}", "          Lamp.Lit: {}"),
        "chart.trap", "Lamp.Lit: {}",
    ),
    "a state that leads only to itself": (
        ("              - {event: SwitchLamp, target: Lamp.Dark}\n"
         "              - {event: Home, target: Lamp.Dark}",
         "              - {event: SwitchLamp, target: Lamp.Lit}"),
        "chart.trap", "Lamp.Lit:",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("swap", "code", "at"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_told_once_and_at_its_place(
    tmp_path: Path, swap: tuple[str, str], code: str, at: str
) -> None:
    robot = load_robot(changed(NEWT, tmp_path, "chart.yaml", swap))

    found = told(check_chart(robot))

    assert [each for each, _ in found] == [code], found
    assert found[0][1].startswith(at)


@pytest.mark.parametrize(
    "guard",
    [
        "In('Crawl.Resting') and not In('Crawl.Ahead')",  # what its own state says, once more
        "not In('Grip.Loose') and In('Crawl.Resting')",
        "In('Crawl.Resting') and not In('Grip.Loose')",  # TailHeld is known not to be Loose
    ],
)
def test_a_careful_guard_is_no_finding(tmp_path: Path, guard: str) -> None:
    robot = load_robot(changed(NEWT, tmp_path, "chart.yaml", nose(guard)))

    assert check_chart(robot) == ()


def parsed(guard: str) -> ast.expr:
    return ast.parse(guard, mode="eval").body


def small(*transitions: str) -> str:
    """A chart of two regions with these transitions of P.one, P.two, Q.one, Q.two."""
    lines = ["states:", "  top:", "    parallel: true", "    states:"]
    for number, region in enumerate("PQ"):
        lines += [f"      {region}:", "        states:"]
        for place, state in enumerate(("one", "two")):
            lines += [f"          {region}.{state}:"]
            lines += ["            initial: true"] * (place == 0)
            lines += [f"            transitions: [{transitions[2 * number + place]}]"]
    return "\n".join(lines)


def codes(text: str) -> list[tuple[str, str]]:
    document = parse_document(text, "chart.yaml")
    problems = Problems(document)
    outline = outline_chart(document, problems)
    assert outline is not None, problems.all
    table = compile_chart(document, outline, problems)
    return told(examine(document, outline, table).findings)


def test_a_combination_without_a_way_out_is_a_trap() -> None:
    text = small(
        "{event: go, target: P.two}",
        "{event: back, target: P.one, cond: In('Q.one')}",
        "{event: on, target: Q.two}",
        "{event: off, target: Q.one, cond: In('P.one')}",
    )

    ((code, at),) = codes(text)

    assert code == "chart.trap"
    assert at.startswith(("Q.two}]", "P.two}]"))


def test_a_command_that_leads_each_state_to_itself_is_idle() -> None:
    text = small(
        "{event: go, target: P.two}, {event: stay, target: P.one}",
        "{event: back, target: P.one}",
        "{event: on, target: Q.two}",
        "{event: off, target: Q.one}",
    )

    assert codes(text) == [("chart.command_idle", "stay, target: P.one}]")]


def test_an_idle_command_may_stand_in_several_regions() -> None:
    text = small(
        "{event: go, target: P.two}",
        "{event: go, target: P.one}",
        "{event: on, target: Q.two}, {event: look, target: Q.one}",
        "{event: on, target: Q.one}, {event: look, target: Q.two}",
    )

    ((code, at),) = codes(text)

    assert (code, at[:4]) == ("chart.command_idle", "look")


def test_the_guard_is_told_and_not_the_states_behind_it(tmp_path: Path) -> None:
    robot = changed(NEWT, tmp_path, "chart.yaml", ahead("In('Crawl.Ahead')"))

    check = check_robot(robot)

    assert check.loaded is None
    assert told(check.findings) == [("chart.guard_never", "In('Crawl.Ahead')\"}")]


def test_a_state_that_no_transition_leads_to_is_told_itself(tmp_path: Path) -> None:
    swap = (AHEAD, "{event: GoAhead, target: Crawl.Astern}")

    check = check_robot(changed(NEWT, tmp_path, "chart.yaml", swap))

    assert told(check.findings) == [("chart.unreachable", "Crawl.Ahead:")]


def test_unreadable_files_are_told_as_loading_tells_them(tmp_path: Path) -> None:
    robot = changed(NEWT, tmp_path, "profile.yaml", ("chart: chart.yaml", "chart: no.yaml"))

    check = check_robot(robot)

    assert [each.code for each in check.findings] == ["robot.chart"]
    assert len(check.documents) == 1


# --- guards ------------------------------------------------------------------------------------

STATES = {"A": ("x", "y", "z"), "B": ("x", "y"), "C": ("only",)}
ATOMS = [f"In('{region}.{state}')" for region, states in STATES.items() for state in states]
GUARDS = st.recursive(
    st.sampled_from(ATOMS),
    lambda inner: st.one_of(
        inner.map(lambda text: f"not ({text})"),
        st.tuples(inner, inner).map(lambda pair: f"({pair[0]}) and ({pair[1]})"),
        st.tuples(inner, inner).map(lambda pair: f"({pair[0]}) or ({pair[1]})"),
    ),
    max_leaves=6,
)


def truths(text: str, fixed: dict[str, str] | None = None) -> set[bool]:
    """What Python makes of a guard over all combinations of states."""
    found = set()
    for row in product(*STATES.values()):
        states = dict(zip(STATES, row, strict=True))
        if fixed is None or fixed.items() <= states.items():
            active = {f"{region}.{state}" for region, state in states.items()}
            found.add(bool(eval(text, {"In": active.__contains__})))
    return found


@given(GUARDS)
def test_a_guard_is_constant_when_trying_everything_says_so(text: str) -> None:
    node = parsed(text)

    for fixed in (None, {"A": "y"}):
        value = guards.constant(node, STATES, fixed)

        tried = truths(text, fixed)
        assert value == (tried.pop() if len(tried) == 1 else None)


def test_a_guard_of_too_many_regions_is_not_judged() -> None:
    states = {f"R{number}": ("a", "b") for number in range(20)}
    text = " or ".join(f"(In('{name}.a') and In('{name}.b'))" for name in states)

    assert guards.constant(parsed(text), states) is None
    parts = list(guards.constant_parts(parsed(text), states))
    assert [value for _, value in parts] == [False] * 20


def test_an_offset_counts_characters_over_lines() -> None:
    text = "(In('Ä.x')\n or In('B.x'))"
    calls = [each for each in ast.walk(parsed(text)) if isinstance(each, ast.Call)]

    assert [text[guards.offset_of(text, each) :][:9] for each in calls] == [
        "In('Ä.x')",
        "In('B.x')",
    ]


# --- against the library -----------------------------------------------------------------------

MOVES = st.tuples(
    st.sampled_from(["go", "on"]),
    st.sampled_from(["one", "two"]),
    st.sampled_from(
        ["", "In('P.one')", "In('Q.two')", "not In('Q.one')", "In('P.two') or In('Q.two')"]
    ),
)


@given(st.lists(st.lists(MOVES, max_size=3), min_size=4, max_size=4))
def test_what_is_never_taken_the_library_never_takes(moves: list) -> None:
    text = small(
        *(
            ", ".join(
                f"{{event: {event}, target: {region}.{target}"
                + (f', cond: "{cond}"}}' if cond else "}")
                for event, target, cond in listed
            )
            for region, listed in zip("PPQQ", moves, strict=True)
        )
    )
    document = parse_document(text, "chart.yaml")
    outline = outline_chart(document, Problems(document))
    assert outline is not None
    if not outline.transitions:
        return  # the library refuses a chart in which nothing happens
    table = compile_chart(document, outline, Problems(document))

    silent = {each.path for each in examine(document, outline, table).silent}

    taken = set()
    for states, row in zip(table.configurations, table.following, strict=True):
        active = dict(zip(table.regions, states, strict=True))
        inside = {f"{region}.{state}" for region, state in active.items()}
        for command, event in enumerate(table.commands):
            expected = dict(active)
            for region in table.regions:
                for each in outline.transitions:
                    if (each.region, each.event) != (region, event) or each.source not in inside:
                        continue
                    if not each.guard or eval(each.guard, {"In": inside.__contains__}):
                        taken.add(each.path)
                        expected[region] = each.target.partition(".")[2]
                        break
            assert table.configurations[row[command]] == tuple(expected.values())
    reached = {f"{r}.{s}" for row in table.configurations for r, s in zip("PQ", row, strict=True)}
    assert silent == {each.path for each in outline.transitions if each.source in reached} - taken


NESTED = """\
states:
  top:
    parallel: true
    states:
      P:
        states:
          P.off:
            initial: true
            transitions: [{event: start, target: P.on}]
          P.on:
            transitions: [{event: stop, target: P.off}, {event: flip, target: P.off}]
            states:
              P.slow: {initial: true, transitions: [{event: FLIP, target: P.fast}]}
              P.fast: {transitions: [{event: FLIP, target: P.slow}]}
      Q:
        states:
          Q.one: {initial: true, transitions: [{event: go, target: Q.two, cond: "GUARD"}]}
          Q.two: {transitions: [{event: go, target: Q.one}]}
"""


def nested(flip: str = "turn", guard: str = "In('P.on')") -> str:
    return NESTED.replace("FLIP", flip).replace("GUARD", guard)


def test_compound_states_that_are_used_with_care_are_no_finding() -> None:
    assert codes(nested()) == []


def test_a_compound_states_transition_that_every_state_inside_overrides_is_never_taken() -> None:
    assert codes(nested("flip")) == [
        ("chart.transition_never", "flip, target: P.off}]"),
    ]


def test_one_that_only_some_states_inside_override_is_taken() -> None:
    text = nested("flip").replace(
        "P.fast: {transitions: [{event: flip", "P.fast: {transitions: [{event: turn"
    )

    assert codes(text) == []


@pytest.mark.parametrize(
    ("guard", "code"),
    [
        ("In('P.on') and In('P.off')", "chart.guard_never"),
        ("In('P.on') or In('P.off')", "chart.guard_always"),
        ("In('P.on') or not In('P.slow')", "chart.guard_always"),
        ("In('P.slow') and not In('P.on')", "chart.guard_never"),
    ],
)
def test_a_guard_knows_what_is_inside_of_a_compound_state(guard: str, code: str) -> None:
    assert code in [found for found, _ in codes(nested(guard=guard))]

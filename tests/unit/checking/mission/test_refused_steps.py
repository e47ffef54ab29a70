"""Steps that are refused on every path, on some, or skipped on all."""

from __future__ import annotations

from pathlib import Path

import pytest

from checking.small_missions import checked, only, told, write
from pirate_sm.checking.mission.check_mission import check_mission

ALWAYS = "start: p\nphases: {p: {do: [HoldNose, GoAhead, FreeNose], go: good}}\n"
SOMETIMES = """
start: p
phases:
  p:
    do: [HoldNose, {command: HoldTail, on_failure: continue}, FreeNose]
    go: good
"""


def test_a_step_that_is_always_refused_is_certain(tmp_path: Path) -> None:
    check = checked(tmp_path, ALWAYS)

    found = only(check, "step.impossible")
    assert (found.severity.word, found.place.line) == ("error", 5)
    assert found.message.startswith("FreeNose is refused as impossible")


def test_a_step_that_is_refused_at_times_is_told_with_the_shortest_story(tmp_path: Path) -> None:
    found = only(checked(tmp_path, SOMETIMES), "step.maybe_impossible")

    assert found.message.startswith("FreeNose can be refused")
    assert len(found.story) == 4  # begun, accepted, done, and HoldTail's array rejected
    assert "HoldTail" in found.story[-1]


def test_a_step_that_says_where_its_refusal_leads_may_be_refused_at_times(tmp_path: Path) -> None:
    body = SOMETIMES.replace("FreeNose]", "{command: FreeNose, on_failure: bad}]")

    assert told(checked(tmp_path, body)) == []


def test_what_is_already_so_is_unneeded(tmp_path: Path) -> None:
    check = checked(tmp_path, "start: p\nphases: {p: {do: [HoldNose, HoldNose], go: good}}\n")

    assert "leave the step out" in only(check, "step.unneeded").fix


def test_what_is_always_skipped_is_never_needed(tmp_path: Path) -> None:
    body = "start: p\nphases: {p: {do: [{command: Rest, unneeded: skip}], go: good}}\n"

    assert ("step.never_needed", "warning") in told(checked(tmp_path, body))


def test_a_step_after_one_that_cannot_run_is_told_as_if_that_were_mended(tmp_path: Path) -> None:
    body = "start: p\nphases: {p: {do: [GoAhead, HoldNose, HoldNose], go: good}}\n"

    found = only(checked(tmp_path, body), "step.unneeded")
    assert found.message.endswith("(after the step before it that cannot run is corrected)")
    assert not found.course  # the mission as it stands never gets there


def test_a_handler_that_cannot_run_is_told_as_such(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p: {do: [HoldNose], on_failure: h, go: good}
  h: {do: [FreeTail], go: bad}
"""
    assert only(checked(tmp_path, body), "handler.impossible").place.line == 7


HANDLED = """
start: p
phases:
  p: {{do: [HoldNose, HoldTail], on_failure: h, go: good}}
  h: {{{handler}do: [{steps}], go: bad}}
"""


@pytest.mark.parametrize(
    ("handler", "steps", "expected"),
    [
        pytest.param("on_failure: bad, ", "GoAhead", [], id="the phase handles its failures"),
        pytest.param("", "GoAhead", [("handler.impossible", "error")], id="nothing handles them"),
        pytest.param(
            "on_failure: bad, ", "HoldNose", [("handler.impossible", "error")],
            id="an unneeded step would keep the next ones from being done",
        ),
        pytest.param(
            "on_failure: bad, ", "FreeTail, Rest", [("handler.impossible", "error")],
            id="a step that is never possible",
        ),
    ],
)  # fmt: skip
def test_a_handler_of_the_phase_counts_as_one(
    tmp_path: Path, handler: str, steps: str, expected: list[tuple[str, str]]
) -> None:
    found = told(checked(tmp_path, HANDLED.format(handler=handler, steps=steps)))

    assert [each for each in found if each[0] == "handler.impossible"][:1] == expected


def test_a_handler_that_fails_only_after_a_second_failure_is_not_certainly_wrong(
    tmp_path: Path,
) -> None:
    steps = "{command: HoldNose, unneeded: skip, on_failure: continue}, GoAhead"
    body = HANDLED.replace("HoldNose, HoldTail", "HoldNose").format(handler="", steps=steps)

    assert told(checked(tmp_path, body)) == [("handler.impossible", "warning")]


def test_a_call_that_says_where_its_refusal_leads_may_be_refused_at_times(tmp_path: Path) -> None:
    inner = "starts_in: {Grip: NoseHeld}\nstart: q\nphases: {q: {do: [HoldTail], go: good}}\n"
    write(tmp_path, inner + "ends: {good: {succeed: ok}}\n", name="sub")
    body = (
        "start: p\nphases: {p: {do: [{command: HoldNose, if: known(neck)}, "
        "{call: sub, on_failure: bad}], go: good}}\n"
    )

    assert told(checked(tmp_path, body)) == []


@pytest.mark.parametrize(
    ("steps", "terms", "fix"),
    [
        ("SwitchLamp", "{Grip: BothHeld}", "put HoldNose, HoldTail before the call"),
        ("HoldNose, GoAhead", "{Grip: BothHeld}", "put Rest, HoldTail before the call"),
        ("HoldNose", "{Grip: Loose}", "no commands lead there from where the robot is"),
    ],
)
def test_the_mend_of_a_call_names_the_commands_that_lead_there(
    tmp_path: Path, steps: str, terms: str, fix: str
) -> None:
    inner = f"starts_in: {terms}\nstart: q\nphases: {{q: {{do: [SwitchLamp], go: good}}}}\n"
    write(tmp_path, inner + "ends: {good: {succeed: ok}}\n", name="sub")
    body = f"start: p\nphases: {{p: {{do: [{steps}, {{call: sub}}], go: good}}}}\n"

    assert only(checked(tmp_path, body), "call.starts_in").fix.startswith(fix)


@pytest.mark.parametrize(
    ("steps", "fix"),
    [
        (
            "{command: HoldNose, on_failure: continue}",
            "HoldNose stands before the call and can fail: let its failure lead elsewhere, "
            "or set `on_failure` at the call",
        ),
        (
            "{command: HoldNose, if: known(neck)}",
            "put HoldNose before the call, with `unneeded: skip`, or set `on_failure` at the call",
        ),
        (
            "{command: HoldNose, if: known(neck)}, {command: HoldTail, if: known(neck)}",
            "put HoldNose, HoldTail before the call, each with `unneeded: skip`, "
            "or set `on_failure` at the call",
        ),
    ],
)
def test_the_mend_of_a_call_that_is_refused_at_times_fits_what_stands_before_it(
    tmp_path: Path, steps: str, fix: str
) -> None:
    terms = "BothHeld" if "HoldTail" in steps else "NoseHeld"
    inner = (
        f"starts_in: {{Grip: {terms}}}\nstart: q\nphases: {{q: {{do: [SwitchLamp], go: good}}}}\n"
    )
    write(tmp_path, inner + "ends: {good: {succeed: ok}}\n", name="sub")
    body = f"start: p\nphases: {{p: {{do: [{steps}, {{call: sub}}], go: good}}}}\n"

    assert only(checked(tmp_path, body), "call.maybe_starts_in").fix == fix


@pytest.mark.parametrize(
    ("phases", "code"),
    [
        ("p: {do: [{call: sub}], go: good}", ""),
        ("p: {do: [HoldNose, {call: sub}], go: good}", "call.starts_in"),
        # The first time its terms are met.
        ("p: {do: [{call: sub}], wait: [{operator: again, go: p}], "
         "within: {time: 1 s, go: good}}", "call.maybe_starts_in"),
    ],
)  # fmt: skip
def test_a_call_needs_its_terms_each_time(tmp_path: Path, phases: str, code: str) -> None:
    inner = "starts_in: {Grip: Loose}\nstart: q\nphases: {q: {do: [HoldTail], go: good}}\n"
    write(tmp_path, inner + "ends: {good: {succeed: ok}}\n", name="sub")

    check = check_mission(write(tmp_path, f"start: p\nphases: {{{phases}}}\n"))

    assert code in {"", *(each.code for each in check.findings)}
    assert bool(code) == any(each.code.startswith("call.") for each in check.findings)

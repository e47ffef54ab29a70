"""What a mission's file becomes: instructions, calls inlined, names of phases, handlers."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core._engine.mission.program import (
    STOP,
    Branch,
    Do,
    Enter,
    Finish,
    Question,
    Raise,
    Require,
    Wait,
)
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.mission.program_writer import MOST_INSTRUCTIONS, Assembly, TooLongError
from pirate_sm.core._loading.problems import LoadError

ROOT = Path(__file__).resolve().parents[5]
NEWT = ROOT / "tests" / "robots" / "newt"
HEAD = "format: 1\nmission: {name}\nrobot: pirate_ii\n"


def mission(body: str, name: str = "m") -> str:
    return HEAD.format(name=name) + body


def one(program, kind):
    return next(each for each in program.instructions if isinstance(each, kind))


CALLED = mission(
    """\
start: x
phases:
  x: {do: [ToggleLighting], go: y}
  y: {wait: [{after: 1 s, go: good}, {operator: no, go: bad}]}
ends: {good: {succeed: Good}, bad: {fail: Bad}}
""",
    "called",
)


def test_a_repeat_is_written_out(load):
    program = load(
        mission(
            "start: a\nphases: {a: {do: [{repeat: {times: 3, do: [Brake, Reset]}}], go: e}}\n"
            "ends: {e: {succeed: ok}}\n"
        )
    ).program

    assert sum(isinstance(each, Do) for each in program.instructions) == 6


def test_a_call_is_written_out_with_its_phases_named_after_the_caller(load):
    program = load(
        mission(
            "start: a\nphases: {a: {do: [{call: called}, {call: called}], go: e}}\n"
            "ends: {e: {succeed: ok}}\n"
        ),
        {"called.yaml": CALLED},
    ).program

    assert program.phases == ("a", "a/called.x", "a/called.y")
    entered = [each.phase for each in program.instructions if isinstance(each, Enter)]
    assert entered == ["a", "a/called.x", "a/called.y", "a/called.x", "a/called.y"]
    assert sum(isinstance(each, Require) for each in program.instructions) == 2
    assert [each.end for each in program.instructions if isinstance(each, Finish)] == ["e"]


def test_a_call_requires_the_whole_initial_configuration_or_what_is_named(load):
    body = "start: a\nphases: {a: {do: [{call: called}], go: e}}\nends: {e: {succeed: ok}}\n"
    whole = load(mission(body), {"called.yaml": CALLED})
    assert len(one(whole.program, Require).states) == 5

    named = CALLED.replace("start: x", "starts_in: {LightingState: On}\nstart: x")
    some = load(mission(body), {"called.yaml": named})
    lighting = some.robot.regions.index("LightingState")
    assert one(some.program, Require).states == ((lighting, "On"),)


@pytest.mark.parametrize(
    ("step", "of_phase", "expected", "handled"),
    [
        ("{call: called}", "", False, False),
        ("{call: called, on_failure: e}", "", True, False),
        ("{call: called}", "on_failure: e, ", False, True),
    ],
)
def test_a_call_tells_whether_its_refusal_is_expected_and_whether_its_phase_handles_it(
    load, step, of_phase, expected, handled
):
    phases = f"phases: {{a: {{{of_phase}do: [{step}], go: e}}}}"
    program = load(
        mission(f"start: a\n{phases}\nends: {{e: {{succeed: ok}}}}\n"), {"called.yaml": CALLED}
    ).program
    required = one(program, Require)

    assert (required.expected, required.handled) == (expected, handled)


@pytest.mark.parametrize("of_repeat", ["", ", on_failure: e"])
def test_a_repeat_that_names_where_a_failure_leads_handles_those_of_its_steps(load, of_repeat):
    step = f"{{repeat: {{times: 1, do: [Brake]}}{of_repeat}}}"
    phases = f"phases: {{a: {{do: [{step}], go: e}}}}"
    program = load(mission(f"start: a\n{phases}\nends: {{e: {{succeed: ok}}}}\n")).program

    assert one(program, Do).handled == bool(of_repeat)


def test_arguments_go_down_and_nothing_else_does(load, faults):
    called = CALLED.replace("start: x", "parameters: {t: {type: duration}}\nstart: x").replace(
        "after: 1 s", "after: $t"
    )
    body = (
        "parameters: {{t: {{type: duration, default: 7 s}}}}\nstart: a\n"
        "phases: {{a: {{do: [{{call: called{}}}], go: e}}}}\nends: {{e: {{succeed: ok}}}}\n"
    )
    program = load(mission(body.format(", with: {t: $t}")), {"called.yaml": called}).program
    assert one(program, Wait).triggers[0].after_s == 7

    files = {"called.yaml": called}
    said = faults(mission(body.format("")), files)
    assert said == ["m.yaml:6:19: 'called' needs the parameter 't'"]
    said = faults(mission(body.format(", with: {t: 5}")), files)
    assert said == [
        "m.yaml:6:44: parameter 't': expected a duration such as '2 s', got '5' without a unit"
    ]
    said = faults(mission(body.format(", with: {s: 5 s}")), files)
    assert said[0].startswith("m.yaml:6:")
    assert "there is no parameter 's'" in " ".join(said)
    said = faults(mission(body.format(", with: {t: $u}")), files)
    assert said[0].startswith("m.yaml:6:44: there is no parameter")


@pytest.mark.parametrize(
    ("files", "fault"),
    [
        ({}, "m.yaml:6:26: there is no mission 'called'"),
        ({"called.yaml": CALLED.replace("ToggleLighting", "Toggle")},
         "called.yaml:6:12: there is no command 'Toggle'"),
        ({"called.yaml": CALLED.replace("after: 1 s", "after: 1")},
         "called.yaml:7:22: expected a duration"),
        ({"called.yaml": "["}, "m.yaml:6:26: this leads to a file that is no mission"),
        ({"called.yaml": CALLED.replace("robot: pirate_ii", "robot: other")},
         "m.yaml:6:26: 'called' is for the robot 'other'"),
        ({"called.yaml": CALLED.replace("start: x", "polarity: mirrored\nstart: x")},
         "m.yaml:6:26: 'called' is mirrored, this mission is normal"),
        ({"called.yaml": CALLED.replace("ToggleLighting", "{call: m}")},
         "called.yaml:6:19: a mission cannot call itself: m → called → m"),
        ({"called.yaml": CALLED.replace("ToggleLighting", "{call: called}")},
         "called.yaml:6:19: a mission cannot call itself: m → called → called"),
        ({"called.yaml": CALLED.replace("ToggleLighting", "{call: third}"),
          "third.yaml": CALLED.replace("ToggleLighting", "{call: called}")},
         "third.yaml:6:19: a mission cannot call itself: m → called → third → called"),
        ({"called.yaml": CALLED.replace("start: x", "starts_in: {LightingState: Of}\nstart: x")},
         "called.yaml:4:28: LightingState has no state 'Of'"),
    ],
)  # fmt: skip
def test_a_fault_of_a_call_is_told_where_it_stands(faults, files, fault):
    said = faults(
        mission(
            "start: a\nphases:\n  a: {do: [Brake, {{call: called}}], go: e}\n".replace(
                "{{", "{"
            ).replace("}}", "}")
            + "ends: {e: {succeed: ok}}\n"
        ),
        files,
    )

    assert [each for each in said if each.startswith(fault)], said


def test_a_mission_that_calls_itself_is_refused(faults):
    said = faults(
        mission("start: a\nphases: {a: {do: [{call: m}], go: e}}\nends: {e: {succeed: ok}}\n")
    )

    assert said == ["m.yaml:5:26: a mission cannot call itself: m → m"]


def test_calls_nest_only_so_deep(faults):
    files = {
        f"c{n}.yaml": CALLED.replace("ToggleLighting", f"{{call: c{n + 1}}}") for n in range(20)
    }
    body = "start: a\nphases: {a: {do: [{call: c0}], go: e}}\nends: {e: {succeed: ok}}\n"

    said = faults(mission(body), files | {"c20.yaml": CALLED})

    assert said == ["c14.yaml:6:19: calls are nested more than 16"]


def test_a_repeat_of_a_call_that_cannot_be_found_is_over_at_once(faults):
    nested = "{repeat: {times: 999999999, do: [{repeat: {times: 999999999, do: [{call: no}]}}]}}"

    said = faults(
        mission(
            f"start: a\nphases: {{a: {{do: [{nested}], go: e}}}}\nends: {{e: {{succeed: x}}}}\n"
        )
    )

    assert len(said) == 1
    assert "there is no mission 'no'" in said[0]


def test_the_same_robot_by_another_path_is_the_same_robot(faults):
    other = CALLED.replace("robot: pirate_ii", f"robot: {ROOT / 'hardware_profiles/pirate_ii'}")
    body = "start: a\nphases: {a: {do: [{call: called}], go: e}}\nends: {e: {succeed: ok}}\n"

    assert faults(mission(body), {"called.yaml": other}) == []


def test_an_alias_is_the_command_it_stands_for(load):
    body = "start: a\nphases: {a: {do: [UnclampFront], go: e}}\nends: {e: {succeed: ok}}\n"
    loaded = load(mission(body))

    assert loaded.robot.commands[one(loaded.program, Do).command].name == "RelaxFront"


def test_fault_handlers_are_in_force_inside_a_call_innermost_first(load):
    called = CALLED.replace("start: x", "on_fault: [{fault: robot.stuck, go: y}]\nstart: x")
    loaded = load(
        mission(
            "on_fault: [{fault: [robot.stuck, motor.hot], go: e}]\n"
            "start: a\nphases: {a: {do: [{call: called}], go: e}}\nends: {e: {succeed: ok}}\n"
        ),
        {"called.yaml": called},
    )
    program = loaded.program
    inside = program.phase_of.index("a/called.y")

    nobodys = frozenset[str]()
    assert program.handler(inside, "robot.stuck", nobodys).go_name == "a/called.y"
    assert program.handler(inside, "motor.hot", nobodys).go_name == "e"
    assert program.handler(program.start, "robot.stuck", nobodys).go_name == "e"
    assert program.handler(program.start, "wheel.dead", nobodys) is None
    assert program.handler(-1, "robot.stuck", nobodys) is None


def test_without_a_handler_a_failure_stops(load):
    assert one(load().program, Do).failed == STOP


def test_a_question_leads_to_continue_fail_and_phases(load):
    program = load(
        mission(
            "start: a\nphases:\n"
            "  a: {do: [{ask: 'Go?', choices: {y: continue, n: fail, b: b}}], go: e}\n"
            "  b: {go: e}\nends: {e: {succeed: ok}}\n"
        )
    ).program
    question = one(program, Question)
    targets = [program.instructions[target] for _, target in question.choices]

    assert [choice for choice, _ in question.choices] == ["y", "n", "b"]
    assert isinstance(targets[0], Finish)
    assert isinstance(targets[1], Raise)
    assert targets[2].phase == "b"


def test_each_trigger_of_a_wait_leads_to_its_own_target(load):
    program = load(
        mission(
            "start: a\nphases:\n"
            "  a: {wait: [{after: 1 s, go: e}, {operator: no, go: b}]}\n"
            "  b: {go: e}\nends: {e: {succeed: ok}}\n"
        )
    ).program
    first, second = one(program, Wait).triggers

    assert isinstance(program.instructions[first.go], Finish)
    assert program.instructions[second.go].phase == "b"
    assert (first.text, second.text) == ("after 1 s", "operator: no")


def test_parameters_are_written_into_messages_as_they_were_given(load):
    text = mission(
        "parameters: {t: {type: duration, default: 90 s}, n: {type: count, default: 3}}\n"
        "start: a\nphases: {a: {go: e}}\nends: {e: {succeed: '{n} times in {t}, {cause}'}}\n"
    )

    assert one(load(text).program, Finish).message == "3 times in 90 s, {cause}"
    assert one(load(text, settings={"t": "2 min"}).program, Finish).message == (
        "3 times in 2 min, {cause}"
    )


@pytest.mark.thorough
def test_every_shipped_mission_names_its_phases_once():
    for path in sorted((ROOT / "sequences").glob("*.yaml")):
        phases = load_mission(path).program.phases
        assert len(set(phases)) == len(phases), path


def test_calls_that_double_are_counted_before_they_are_written_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Thirty missions, each of which calls the next one twice, took 42 s to be refused."""
    for number in range(31):
        again = f"{{call: ./m{number + 1}.yaml}}"
        steps = f"[{again}, {again}]" if number < 30 else "[{log: Here}]"
        (tmp_path / f"m{number}.yaml").write_text(
            f"format: 1\nmission: m{number}\nrobot: {NEWT}\nstart: a\n"
            f"phases: {{a: {{do: {steps}, go: e}}}}\nends: {{e: {{succeed: Done}}}}\n",
            encoding="utf-8",
        )
    monkeypatch.setattr(Assembly, "emit", None)  # nothing is to be written

    with pytest.raises(LoadError) as raised:
        load_mission(tmp_path / "m0.yaml")

    assert [each.code for each in raised.value.problems] == ["mission.too_long"]


def test_a_mission_for_another_robot_is_not_read_with_the_names_of_this_one(faults):
    called = CALLED.replace("robot: pirate_ii", f"robot: {NEWT}")
    body = "start: a\nphases: {a: {do: [{call: called}], go: e}}\nends: {e: {succeed: ok}}\n"

    (said,) = faults(mission(body), {"called.yaml": called.replace("ToggleLighting", "SwitchLamp")})

    assert "'called' is for the robot" in said


def test_only_the_condition_of_a_wait_may_count_from_its_beginning(faults):
    (said,) = faults(
        mission(
            "start: a\nphases: {a: {do: [{command: Brake, if: change(odometry) > 1 mm}], go: e}}\n"
            "ends: {e: {succeed: ok}}\n"
        )
    )

    assert "'change' counts from the beginning of a wait" in said


def test_a_choice_with_nothing_to_do_is_a_choice(load):
    program = load(
        mission(
            "start: a\nphases:\n  a:\n    do:\n"
            "      - choose: [{if: known(odometry), do: []}]\n        else: [Brake]\n"
            "    go: e\nends: {e: {succeed: ok}}\n"
        )
    ).program
    nothing = program.instructions[one(program, Branch).if_true]

    assert isinstance(nothing, Require)
    assert isinstance(program.instructions[nothing.next], Finish)


def test_a_program_has_as_many_instructions_as_are_allowed_and_no_more():
    assembly = Assembly()
    for _ in range(MOST_INSTRUCTIONS):
        assembly.emit(Enter, "a", ())

    with pytest.raises(TooLongError):
        assembly.emit(Enter, "a", ())

"""A mission's file: every misuse is one clear message with its place, and exit code 2."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core.errors import UsageError

ROOT = Path(__file__).resolve().parents[5]
SHIPPED = [
    *sorted((ROOT / "sequences").glob("*.yaml")),
    *sorted((ROOT / "docs" / "examples").glob("*.yaml")),
    *sorted((ROOT / "tests" / "robots" / "newt").glob("p*l.yaml")),
]
HEAD = "format: 1\nmission: m\nrobot: pirate_ii\n"
ENDS = "ends: {e: {succeed: ok}}\n"
CYCLE = "expected at least 16 ms, one cycle of the robot's bus"


def steps(listed: str) -> str:
    """A mission with these steps in its line 6, column 8 on."""
    return f"{HEAD}start: a\nphases:\n  a: {{do: [{listed}], go: e}}\n{ENDS}"


def phase(body: str) -> str:
    """A mission with this phase in its line 6, from column 7 on."""
    return f"{HEAD}start: a\nphases:\n  a: {{{body}}}\n{ENDS}"


def with_line(line: str) -> str:
    """A mission with one more line, its fourth."""
    return f"{HEAD}{line}\nstart: a\nphases: {{a: {{do: [ClampFront], go: e}}}}\n{ENDS}"


@pytest.mark.thorough
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_what_is_shipped_loads(path):
    loaded = load_mission(path)

    assert all(len(digest) == 64 for digest in loaded.files.values())


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        # commands
        (steps("ClampFrnt"), "6:12: there is no command 'ClampFrnt'"),
        (steps("{command: ClampFrnt}"), "6:22: there is no command 'ClampFrnt'"),
        (steps("AlignOther"), "6:12: 'AlignOther' is not a command: aligning to the opposite side"),
        (steps("5"), "6:12: expected a step: a command's name, or a mapping with one of command"),
        (steps("{}"), "6:12: expected a step"),
        (steps("[ClampFront]"), "6:12: expected a step"),
        (phase("do: ClampFront, go: e"), "6:11: expected a list, got the text 'ClampFront'"),
        (steps("{command: Brake, retri: 2}"), "6:29: unknown key 'retri'"),
        (steps("{command: Brake, unneeded: maybe}"), "6:39: expected one of skip, fail"),
        (steps("{command: Brake, retry: -1}"), "6:36: expected a count of at least 0, got -1"),
        (steps("{command: Brake, retry: 101}"), "6:36: expected a count of at most 100, got 101"),
        (steps("{command: Brake, retry: $often}").replace(
            "start:", "parameters: {often: {type: count, default: 9999}}\nstart:", 1),
         "7:36: expected a count of at most 100, got 9999"),
        (steps("{command: Brake, retry: 1.5}"), "6:36: expected a count such as 3, got '1.5'"),
        (steps("{command: Brake, timeout: 5}"), "6:38: expected a duration such as '2 s', got '5'"),
        (steps("{command: Brake, timeout: 5 mm}"), "6:38: expected a duration such as '2 s'"),
        (steps("{command: Brake, timeout: 5 sek}"), "6:38: expected a duration such as '2 s'"),
        (steps("{command: Brake, timeout: 0 s}"), f"6:38: {CYCLE}, got 0 ms"),
        (steps("{command: Brake, timeout: -1 s}"), f"6:38: {CYCLE}, got -1 s"),
        (steps("{command: Brake, timeout: $x}"), "6:38: there is no parameter 'x'"),
        (steps("{command: Brake, timeout: $}"), "6:38: expected a parameter such as '$give_up'"),
        (steps("{command: Brake, on_failure: b}"), "6:41: there is no phase or end 'b'"),
        (steps("{command: Brake, if: 5}"), "6:33: expected text, got the number 5"),
        (steps("{command: Brake, if: odometry}"), "6:33: a condition is expected"),
        (steps("{comand: Brake, timeout: 2 s}"), "6:13: expected a step: a command's name, or a"),
        # other steps
        (steps("{repeat: {times: 0, do: [Brake]}}"), "6:29: repeat at least once"),
        (steps("{repeat: {times: 2, do: []}}"), "6:36: this is empty"),
        (steps("{repeat: {times: 30000, do: [Brake]}}"),
         "6:29: with its repeats and calls written out it has more than 20000 steps"),
        (steps("{repeat: {times: 200, do: [{repeat: {times: 200, do: [Brake]}}]}}"),
         "6:29: with its repeats and calls written out"),
        (steps("{choose: []}"), "6:21: this is empty"),
        (steps("{choose: [{if: odometri > 1 m, do: [Brake]}]}"), "6:27: unknown name 'odometri'"),
        (steps("{ask: Go on?, choices: {yes: b}}"), "6:41: there is no phase or end 'b'"),
        (steps("{ask: Go on?, choices: {}}"), "6:26: this is empty"),
        (steps("{ask: Go on?, timeout: 0 s}"), "6:35: expected at least 16 ms"),
        (steps("{log: 'in {where}'}"), "6:18: there is no parameter 'where'"),
        (steps("{log: x, level: error}"), "6:28: expected one of info, warning"),
        (steps("{control: exp_3}"), "6:22: there is no control 'exp_3'"),
        (steps("{control: ''}"), "6:22: there is no control ''"),
        (steps("{control: [exp_3a]}"), "6:22: expected text"),
        (steps("{control: exp_3a, timeout: 0 s}"), f"6:39: {CYCLE}, got 0 ms"),
        (steps("{control: exp_3a, timeout: 5}"), "6:39: expected a duration such as '2 s', got"),
        (steps("{control: exp_3a, on_failure: b}"), "6:42: there is no phase or end 'b'"),
        (steps("{control: exp_3a, retry: 1}"), "6:30: unknown key 'retry'"),
        (with_line("control: exp_3"), "4:10: there is no control 'exp_3'"),
        (with_line("control: 5"), "4:10: expected text, got the number 5"),
        # phases
        (phase("do: [Brake]"), "6:3: a phase without `wait` needs `go`"),
        (phase("go: b"), "6:11: there is no phase or end 'b'"),
        (phase("go: e, resume: b"), "6:22: there is no phase 'b'"),
        (phase("go: e, resume: e"), "6:22: there is no phase 'e'"),
        (phase("go: e, resume: [a]"), "6:22: expected text, got a list"),
        (phase("wait: [{when: 'true', go: e}]"), "6:3: a phase with `wait` needs `within"),
        (phase("do: [Brake], within: {time: 1 s, go: e}, go: e"),
         "6:3: `within` limits a `wait`, and this phase has none"),
        (phase("wait: [{after: 1 s, go: e}], go: e"), "6:3: a phase with `wait` has no `go`"),
        (phase("wait: [{after: -1 s, go: e}]"), f"6:22: {CYCLE}, got -1 s"),
        (phase("wait: [{after: 1 s, go: b}]"), "6:31: there is no phase or end 'b'"),
        (phase("wait: [{after: 1 s, go: e, name: n}, {after: 2 s, go: e, name: n}]"),
         "6:70: 'n' names another trigger here"),
        (phase("wait: [{after: 1 s, go: e, name: within}]"),
         "6:40: 'within' names another trigger here"),
        (phase("wait: [{go: e}], within: {time: 1 s, go: e}"), "6:14: expected a trigger"),
        (phase("wait: [{when: 'true', held: 1 ms, go: e}], within: {time: 1 s, go: e}"),
         f"6:35: {CYCLE}, or 0 s, got 1 ms"),
        (phase("wait: [{when: 'true', held: 1, go: e}], within: {time: 1 s, go: e}"),
         "6:35: expected a duration such as '2 s', got '1' without a unit"),
        (phase("wait: [{when: 'true', go: e}], within: {time: 1 s, go: b}"),
         "6:62: there is no phase or end 'b'"),
        (phase("wait: [{when: 'true', go: e}], within: {time: -1 s, go: e}"),
         f"6:53: {CYCLE}, got -1 s"),
        (phase("wait: [{when: 'true', go: e}], within: 1 s"), "6:46: expected a mapping"),
        (phase("go: e, on_failure: a"), ""),
        (phase("do: [Brake], go: e, on_failure: a"), "6:39: a phase cannot handle its"),
        (f"{HEAD}start: a\nphases:\n{ENDS}", "5:8: expected a mapping, got nothing"),
        (f"{HEAD}start: a\nphases: {{}}\n{ENDS}", "5:1: this is empty"),
        (f"{HEAD}start: a\nphases: {{a: }}\n{ENDS}", "5:13: expected a mapping, got nothing"),
        (f"{HEAD}start: a\nphases: {{a b: {{go: e}}}}\n{ENDS}", "5:10: the text 'a b' does"),
        # conditions
        (phase("wait: [{when: odometri > 1 m, go: e}], within: {time: 1 s, go: e}"),
         "6:21: unknown name 'odometri'"),
        (phase("wait: [{when: odometry > 1, go: e}], within: {time: 1 s, go: e}"),
         "6:32: '1' needs a unit here"),
        (phase("wait: [{when: detector == closed, go: e}], within: {time: 1 s, go: e}"),
         "6:33: 'detector' is never 'closed', only one of close, in, past"),
        (phase("wait: [{when: $x > 1 m, go: e}], within: {time: 1 s, go: e}"),
         "6:21: there is no parameter '$x'"),
        (phase("wait: [{when: \"__import__('os').x\", go: e}], within: {time: 1 s, go: e}"),
         "6:33: words stand without quotes here"),
        (phase("wait: [{when: odometry.real > 1 m, go: e}], within: {time: 1 s, go: e}"), "6:29: "),
        (phase("wait: [{when: open(roll), go: e}], within: {time: 1 s, go: e}"), "6:21: "),
        # the mission
        (with_line("time_limit: 0 s"), "4:13: expected at least 16 ms"),
        (with_line("time_limit: 5"), "4:13: expected a duration such as '2 s'"),
        (with_line("on_failure: b"), "4:13: there is no phase or end 'b'"),
        (with_line("on_fault: [{fault: robot.stuk, go: a}]"), "4:20: there is no fault"),
        (with_line("on_fault: [{fault: [robot.stuck, robot.stuk], go: a}]"),
         "4:34: there is no fault 'robot.stuk'"),
        (with_line("on_fault: [{fault: stuck, go: a}]"), "4:20: the text 'stuck' does not fit"),
        (with_line("on_fault: [{fault: link.silnt, go: a}]"),
         "4:20: there is no fault 'link.silnt', and 'link.silent' cannot be caught: it always"),
        (with_line("on_fault: [{fault: link.lost, go: a}]"), "4:20: 'link.lost' cannot be caught"),
        (with_line("on_fault: [{fault: robot.fallen, then: continue}]"),
         "4:20: 'robot.fallen' cannot be caught"),
        (with_line("on_fault: [{fault: robot.stuck, go: b}]"), "4:37: there is no phase"),
        (with_line("on_fault: [{fault: robot.stuck}]"), "4:12: expected either"),
        (with_line("on_fault: [{fault: robot.stuck, go: a, then: continue}]"),
         "4:40: expected either `then: continue` or `go: <phase>`"),
        (with_line("starts_in: {BendingStat: Unclamped}"), "4:13: there is no region"),
        (with_line("starts_in: {LightingState: off}"), "4:28: LightingState has no state 'off'"),
        (with_line("starts_in: {BendingState: DoubleClamped}"),
         "4:12: no commands lead to FrontWheelsState Free"),
        (with_line("polarity: backwards"), "4:11: expected one of normal, mirrored"),
        (with_line("pipe: mitre_9"), "4:7: there is no pipe 'mitre_9'; did you mean 'mitre_90'?"),
        (with_line("pipe: nowhere/pipe.yaml"), "4:7: there is no pipe at 'nowhere/pipe.yaml'"),
        (with_line("pipe: 5"), "4:7: expected text or a mapping, got the number 5"),
        (with_line("pipe: {diameter: 120, segments: [{straight: 1 m}]}"), "4:18: expected a"),
        (with_line("pipe: {diameter: 300 mm, segments: [{straight: 1 m}]}"),
         "4:18: pirate_ii cannot clamp an inner diameter of 300 mm"),
        (with_line("robots: x"), "4:1: unknown key 'robots'"),
        (with_line("mission: n"), "4:1: the key 'mission' appears twice"),
        (HEAD.replace("pirate_ii", "pirat_ii") + f"start: a\nphases: {{a: {{go: e}}}}\n{ENDS}",
         "3:8: there is no robot 'pirat_ii'; did you mean 'pirate_ii'?"),
        (HEAD.replace("format: 1", "format: 2") + f"start: a\nphases: {{a: {{go: e}}}}\n{ENDS}",
         "1:9: this program reads format 1, and this is format 2"),
        (f"{HEAD}start: b\nphases: {{a: {{go: e}}}}\n{ENDS}", "4:8: there is no phase or end 'b'"),
        (f"{HEAD}start: e\nphases: {{a: {{go: e}}}}\n{ENDS}",
         "4:8: 'e' is an end: start with a phase"),
        (f"{HEAD}start: a\nphases: {{a: {{go: e}}, e: {{go: e}}}}\n{ENDS}",
         "6:8: 'e' is a phase too"),
        (f"{HEAD}start: a\nphases: {{a: {{go: fail}}}}\nends: {{fail: {{fail: x}}}}\n",
         "6:8: 'fail' has a meaning of its own"),
        (f"{HEAD}start: a\nphases: {{a: {{go: e}}}}\nends: {{e: {{}}}}\n",
         "6:8: expected either `succeed: <message>` or `fail: <message>`"),
        (f"{HEAD}start: a\nphases: {{a: {{go: e}}}}\nends: {{e: {{succeed: '{{x}}'}}}}\n",
         "6:"),
        (f"{HEAD}start: a\nphases: {{a: {{go: e}}}}\n", "1:1: the key 'ends' is missing"),
    ],
)  # fmt: skip
def test_a_fault_is_told_once_with_its_place(faults, text, fault):
    said = faults(text)

    if not fault:
        assert said == []
        return
    assert [each for each in said if each.startswith(f"m.yaml:{fault}")], said
    assert len(said) == len(set(said))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"ELF\x00\x01", "is a binary file"),
        (b"\xff\xfem\x00", "UTF-16"),
        (b"\x89PNG\r\n\x1a\n", "0x89 is not UTF-8"),
        (b"a: &a [*a]", "stands for what it is part of"),
        (b"[" * 100_000, "nested deeper than 32 levels"),
        (b"a: {" * 5000, "nested deeper than 32 levels"),
        (
            b"a: &a [x,x,x,x,x,x,x,x,x]\n"
            + b"".join(
                b"%c: &%c [%s]\n" % (98 + n, 98 + n, b",".join([b"*%c" % (97 + n)] * 9))
                for n in range(9)
            ),
            "more than",
        ),
        (b"x" * (2 << 20), "larger than 1 MiB"),
        (b"a: !!python/object/apply:os.system [x]", "is not allowed"),
        (b"hello", "expected a mapping, got the text 'hello'"),
        (b"- a", "expected a mapping, got a list"),
        (b"a: b\n---\na: c", "a second document"),
        (b"a: [", "is missing"),
        (b"\tformat: 1", "tab"),
    ],
)
def test_a_file_that_is_no_mission_is_refused(tmp_path, content, message):
    file = tmp_path / "m.yaml"
    file.write_bytes(content)

    with pytest.raises(LoadError, match=message):
        load_mission(file)


def test_a_file_that_is_not_there_or_a_folder_is_refused(tmp_path):
    for path, message in (
        (tmp_path / "none.yaml", "there is no such file"),
        (tmp_path, "is a directory"),
        (Path("\0.yaml"), "cannot be read"),
        (Path("a" * 5000 + ".yaml"), "cannot be read"),
    ):
        with pytest.raises(LoadError, match=message):
            load_mission(path)


@pytest.mark.parametrize(
    ("text", "place", "hint"),
    [
        (steps("{comand: Brake}"), "6:13", "did you mean 'command'?"),
        (steps("{command: Brake, on_failure: contineu}"), "6:41", "did you mean 'continue'?"),
        (steps("{command: Brake, on_failure: b}"), "6:41", "expected one of continue, a, e"),
        (steps("{ask: Go on?, choices: {yes: b}}"), "6:41", "expected one of continue, fail, a, e"),
        (phase("do: [Brake], go: b"), "6:24", "expected one of a, e"),
        (
            steps("{command: Brake, timeout: 5km}"),
            "6:38",
            "expected a number with a unit, one of us",
        ),
        (
            steps("Brake").replace("succeed: ok", "fail: 'no {couse}'"),
            "7:18",
            "did you mean 'cause'?",
        ),
    ],
)
def test_a_fault_is_told_with_a_way_to_mend_it(text, place, hint, tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text(text, encoding="utf-8")

    with pytest.raises(LoadError) as caught:
        load_mission(file)

    (problem,) = caught.value.problems
    assert f"{problem.place.line}:{problem.place.column}" == place
    assert f"\n  {hint}" in problem.render()


def test_all_faults_of_a_mission_are_reported_at_once(faults):
    said = faults(
        f"""{HEAD}start: nowhere
on_failure: gone
starts_in: {{BendingStat: X, LightingState: off}}
on_fault:
  - {{fault: robot.stuk, go: a}}
  - {{fault: robot.stuck, go: q}}
phases:
  a:
    do: [ClampFrnt, AlignOther, {{command: ClampFront, timeout: $nope}}]
    wait: [{{when: odometri > 5 mm, go: x}}, {{when: "gamma_1 > 5", go: e}}]
    within: {{time: 5 s, go: y}}
ends: {{e: {{succeed: "{{who}}"}}}}
"""
    )
    places = [each.split(": ")[0] for each in said]

    assert places == [
        f"m.yaml:{place}"
        for place in (
            "4:8", "5:13", "6:13", "6:44", "8:13", "9:30", "12:10", "12:21", "12:64", "13:19",
            "13:40", "13:62", "14:29", "15:21",
        )
    ]  # fmt: skip


def test_the_printed_sequence_is_refused_for_its_three_reasons(capsys):
    printed = ROOT / "tests" / "missions" / "enter_3d_as_printed.yaml"

    with pytest.raises(LoadError, match="AlignOther") as caught:
        load_mission(printed)

    assert "AlignLeft or AlignRight" in str(caught.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"robot": "pirat_ii"}, "there is no robot 'pirat_ii'; did you mean 'pirate_ii'?"),
        ({"pipe": "mitre_91"}, "there is no pipe 'mitre_91'; did you mean 'mitre_90'?"),
        ({"settings": {"x": "1"}}, "the mission has no parameter 'x': it has none"),
        ({"start_phase": "b"}, "the mission has no phase 'b': expected a"),
        ({"start_phase": "e"}, "the mission has no phase 'e': expected a"),
        ({"states": {"Bend": "x"}}, "there is no region 'Bend'"),
        ({"states": {"LightingState": "off"}}, "LightingState has no state 'off'"),
        (
            {"states": {"FrontWheelsState": "Fixed"}},
            "no commands lead to FrontWheelsState Fixed with RearWheelsState Free, .* not declared",
        ),
    ],
)
def test_an_argument_that_does_not_fit_is_refused(load, options, message):
    with pytest.raises(UsageError, match=message) as caught:
        load(**options)

    assert caught.value.exit_code == 2


def test_a_parameter_without_a_default_must_be_given(load):
    text = with_line("parameters: {way: {type: length}}")
    with pytest.raises(UsageError, match=r"'way' has no default: give it with set=\{'way': "):
        load(text)

    assert load(text, settings={"way": "5 cm"}).parameters == {"way": "5 cm"}


def test_all_parameters_without_a_default_are_named(load):
    text = with_line("parameters: {way: {type: length}, rest: {type: duration}}")

    with pytest.raises(UsageError) as caught:
        load(text)

    assert caught.value.for_terminal == (
        "parameters 'way' and 'rest' have no default: give them with --set way=… --set rest=…"
    )


def test_of_an_unknown_fault_those_are_named_that_a_mission_may_handle(load):
    with pytest.raises(LoadError) as caught:
        load(with_line("on_fault: [{fault: no.way, then: continue}]"))

    (problem,) = caught.value.problems
    assert "link.interrupted" in problem.expected
    assert not {"link.silent", "link.lost", "link.no_echo"} & set(problem.expected.split(", "))


def test_a_pipe_from_the_command_line_takes_the_missions_place(load):
    assert load(with_line("pipe: mitre_90"), pipe="straight_113").pipe_name == "straight_113"
    with pytest.raises(LoadError, match="cannot clamp an inner diameter"):
        load(
            with_line("pipe: wide.yaml"),
            {"wide.yaml": "{format: 1, diameter: 1 m, segments: [{straight: 1 m}]}"},
        )


def test_the_faults_of_a_pipe_are_told_beside_those_of_the_mission(faults):
    said = faults(
        f"{HEAD}pipe: p.yaml\nstart: b\nphases: {{a: {{go: e}}}}\n{ENDS}",
        {"p.yaml": "{format: 1, diameter: 1, segments: [{straight: 1 m}]}"},
    )

    assert [each.split(": ")[0] for each in said] == ["m.yaml:5:8", "p.yaml:1:23"]


def test_a_mission_begins_with_the_phase_that_is_asked_for(load):
    two = f"{HEAD}start: a\nphases: {{a: {{go: e}}, b: {{go: e}}}}\n{ENDS}"
    loaded = load(two, start_phase="b")
    program = loaded.program

    assert program.phase_of[program.start] == "b"


TOKENS = st.sampled_from(
    [
        *("format", "mission", "robot", "phases", "ends", "start", "do", "go", "wait", "within"),
        *("when", "held", "if", "call", "command", "repeat", "times", "choose", "else", "ask"),
        *("choices", "log", "parameters", "on_fault", "fault", "then", "continue", "pipe", "time"),
        *("ClampFront", "pirate_ii", "a", "e", "5 s", "1", "true", "null", "$x", "{x}", "-1 s"),
    ]
)
TREES = st.recursive(
    st.one_of(TOKENS, st.integers(-5, 5), st.booleans(), st.none(), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(TOKENS, inner, max_size=5)
    ),
    max_leaves=25,
)


@given(tree=TREES)
def test_no_tree_of_words_of_the_language_is_more_than_refused(tmp_path_factory, tree):
    base = {
        "format": 1, "mission": "m", "robot": "pirate_ii", "start": "a",
        "phases": {"a": {"go": "e"}}, "ends": {"e": {"succeed": "ok"}},
    }  # fmt: skip
    for whole in (tree, {**base, "phases": {"a": tree}}, {**base, "phases": {"a": {"do": [tree]}}}):
        file = tmp_path_factory.getbasetemp() / "tree.yaml"
        file.write_text(json.dumps(whole), encoding="utf-8")
        with suppress(LoadError, UsageError):
            load_mission(file)

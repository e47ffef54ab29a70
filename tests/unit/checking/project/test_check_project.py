"""Files and folders checked in one run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from representative import thorough_but

from checking.small_missions import MISSION
from pirate_sm.checking import check_file
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.checking.reports.machine_readable import sarif_report
from pirate_sm.checking.reports.text import text_report
from pirate_sm.core.documents import FileKind, Place
from pirate_sm.core.errors import UsageError

from ..robots import NEWT, ROOT, changed, swap

PANEL = """\
format: 1
panel: p
robot: pirate_ii
device: P
controls: {A: 1, B: 2}
buttons: {A: {do: stop}, B: {command: Fly}}
"""
PIPE = "format: 1\npipe: p\ndiameter: 120 mm\nsegments: [{straight: 1 m}]\n"


def write(path: str, text: str = MISSION) -> str:
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return path


def told(report: CheckReport) -> list[tuple[str, str]]:
    return [(each.code, str(each.place)) for each in report.findings]


def codes(*paths: str) -> list[str]:
    return [each.code for each in check_paths(paths).findings]


def test_a_panel_is_held_against_its_robot_or_the_one_that_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    panel = write("panels/p.yaml", PANEL)

    assert told(check_paths([panel])) == [("panel.command", "panels/p.yaml:6:39")]
    write("panels/p.yaml", PANEL.replace("robot: pirate_ii\n", ""))
    assert told(check_paths([panel])) == []
    named = check_paths([panel], Wishes(robot=str(NEWT)))
    assert [code for code, _ in told(named)] == ["panel.command"]
    write("panels/p.yaml", PANEL.replace("pirate_ii", "pirate_3"))
    assert told(check_paths([panel])) == [("panel.robot", "panels/p.yaml:3:8")]


@pytest.mark.parametrize("path", ["docs/examples", "tests/robots/newt"])
def test_examples_and_the_second_robot_have_no_errors(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)

    assert not check_paths([path]).fails(Severity.ERROR)


def test_everything_that_is_wrong_is_told_at_once_by_place() -> None:
    write("a.yaml", MISSION.replace("go: e", "go: f"))
    write("b.yaml", PIPE.replace("120 mm", "120"))
    write("c.yaml", MISSION.replace("mission: m", "mission: [m"))

    assert told(check_paths(["."])) == [
        ("mission.name", "a.yaml:6:29"),
        ("quantity", "b.yaml:3:11"),
        ("syntax", "c.yaml:2:10"),
    ]


def test_a_broken_robot_is_told_once_however_many_missions_use_it(tmp_path: Path) -> None:
    robot = changed(NEWT, tmp_path, "profile.yaml", ("wheel_radius: 20 mm", "wheel_radius: 20"))
    for name in ("patrol", "take_hold"):
        assert (robot / f"{name}.yaml").exists()

    assert told(check_paths(["newt"])) == [("quantity", "newt/profile.yaml:9:17")]


def test_a_fault_in_a_called_mission_is_told_once() -> None:
    write("inner.yaml", MISSION.replace("mission: m", "mission: inner").replace("go: e", "go: f"))
    outer = MISSION.replace("[ClampFront]", "[{call: inner}]")
    write("one.yaml", outer)
    write("two.yaml", outer)

    assert told(check_paths(["."])) == [("mission.name", "inner.yaml:6:29")]


def test_what_is_none_of_ours_matters_only_when_it_is_named() -> None:
    write("docker.yaml", "services: {}\n")
    write("helm.yaml", "a: {{ b }}\n")
    write("notes.txt", "hello\n")

    assert codes("docker.yaml", "helm.yaml", "notes.txt") == ["check.kind", "key", "check.kind"]
    assert codes(".") == ["check.nothing"]


def test_a_chart_without_a_robot_is_judged_by_its_form() -> None:
    text = (NEWT / "chart.yaml").read_text("utf-8")
    write("chart.yaml", text.replace("initial: true", "initial: false", 1))

    assert codes("chart.yaml") == ["chart.initial"]


def test_a_profile_of_another_name_is_reported() -> None:
    shutil.copy(NEWT / "profile.yaml", "newt.yaml")

    assert codes("newt.yaml") == ["check.kind"]


def test_a_calibration_is_held_against_its_robot() -> None:
    shutil.copytree(NEWT, "newt")
    zeros = "format: 1\nrobot: {}\ndate: 2026-02-01\nzeros: {{{}: 2 deg}}\n"
    good = write("newt/calibration-2026-02-01.yaml", zeros.format("newt", "neck"))
    assert codes(good) == []
    write(good, zeros.format("newt", "nek"))
    assert codes(good) == ["calibration.joint"]
    alone = write("calibration.yaml", zeros.format("nobody", "neck"))
    assert codes(alone) == ["calibration.robot"]


@pytest.mark.parametrize(
    "text", ["- {phase: a, trigger: b}\n", "format: 1\ncourse:\n- {happens: start}\n"]
)
def test_a_trace_script_is_known_in_both_forms(text: str) -> None:
    write("script.yaml", text)

    report = check_paths(["script.yaml"])
    assert (told(report), report.files[0].kind) == ([], FileKind.SCRIPT)


def test_a_trace_script_is_told_all_that_a_run_would_refuse() -> None:
    entries = "- {trigger: a, aftr: 3 s}\n- {trigger: a, after: 3 kg}\n- 7\n"
    script = write("script.yaml", entries + "- {phase: a, tigger: b}\n")
    course = write("course.yaml", "format: 1\ncourse:\n- {happens: begin}\n")

    assert codes(script) == ["unknown-key", "quantity", "kind", "unknown-key"]
    assert codes(course) == ["choice"]


def test_a_finding_is_allowed_in_its_file() -> None:
    lost = "  b: {go: e}"
    text = MISSION.replace("ends:", f"{lost}  # pirate: allow phase.unreachable: for later\nends:")
    write("m.yaml", text)

    report = check_paths(["m.yaml"])
    assert [(each.code, each.allowed) for each in report.findings] == [
        ("phase.unreachable", "for later")
    ]
    assert not report.fails(Severity.WARNING)
    assert (len(report.open), len(report.allowed)) == (0, 1)


def test_what_a_called_mission_allows_is_not_told_of_the_caller(tmp_path: Path) -> None:
    file = tmp_path / "caller.yaml"
    file.write_text(
        "format: 1\nmission: caller\nrobot: pirate_ii\npipe: mitre_90\nstart: a\n"
        "phases: {a: {do: [{call: mitre_bend}], go: e}}\nends: {e: {succeed: Round it}}\n"
    )
    report = check_paths([str(file)], Wishes())
    assert any(each.allowed for each in report.findings)
    assert not report.allowed


def test_an_allowance_in_a_file_that_cannot_be_used_is_seen() -> None:
    write("m.yaml", MISSION + "more: 1  # pirate: allow unknown-key: because\n")

    assert codes("m.yaml") == ["unknown-key", "allow.unused"]


def test_settings_are_for_the_missions_that_have_them() -> None:
    with_it = MISSION.replace("start:", "parameters: {way: {type: length}}\nstart:")
    use = with_it.replace("[ClampFront]", "[ClampFront, DriveForward]")
    use = use.replace("go: e}", "wait: [{when: odometry > $way, go: e}, {after: $t, go: e}]}")
    use = use.replace("{way:", "{t: {type: duration, default: 9 s}, way:")
    write("with.yaml", use)
    write("without.yaml")

    assert codes(".") == ["mission.parameter"]
    assert told(check_paths(["."], Wishes(settings={"way": "1 m"}))) == []
    with pytest.raises(UsageError, match="has a parameter 'wya'"):
        check_paths(["."], Wishes(settings={"wya": "1 m"}))
    with pytest.raises(UsageError, match="without a unit"):
        check_paths(["."], Wishes(settings={"way": "1"}))


def test_names_are_looked_at_although_another_phase_has_no_shape() -> None:
    more = "phases:\n  b: {do: [ClampFrond, {clamp: rear}], go: e}\n  c: {do: [ClampReer], go: f}"
    write("m.yaml", MISSION.replace("phases:", more))

    assert told(check_paths(["m.yaml"])) == [
        ("step", "m.yaml:6:24"),
        ("mission.command", "m.yaml:7:12"),
        ("mission.name", "m.yaml:7:28"),
    ]


@pytest.mark.parametrize("wrong", ["40 mm", "200 mm"])
def test_a_pipe_alone_is_checked_for_the_reach_of_the_usual_robot(wrong: str) -> None:
    pipe = write("p.yaml", PIPE.replace("120 mm", wrong))

    (found,) = check_paths([pipe]).findings

    assert (found.code, str(found.place)) == ("pipe.reach", "p.yaml:3:11")
    assert found.message == f"pirate_ii cannot clamp an inner diameter of {wrong}"


def test_every_diameter_of_a_pipe_alone_counts() -> None:
    pipe = write(
        "p.yaml",
        """\
format: 1
pipe: p
section: round
diameter: 120 mm
segments: [{straight: 1 m}, {reducer: 100 mm, to: 40 mm}, {straight: 1 m}]
""",
    )

    assert told(check_paths([pipe])) == [("pipe.reach", "p.yaml:5:51")]


def test_the_robot_of_a_pipe_alone_is_the_named_one_then_the_one_beside_it_then_the_usual(
    tmp_path: Path,
) -> None:
    pipe = write("p.yaml", PIPE)  # the newt is too small for it
    shutil.copytree(NEWT, tmp_path / "newt")
    beside = write("newt/p.yaml", PIPE)

    assert told(check_paths([pipe])) == []
    assert codes(beside) == ["pipe.reach"]
    for wishes in (Wishes(robot=str(NEWT)), Wishes(usual_robot=str(NEWT))):
        assert [each.code for each in check_paths([pipe], wishes).findings] == ["pipe.reach"]
    assert check_paths([pipe], Wishes(robot="pirate_ii", usual_robot=str(NEWT))).findings == ()


@pytest.mark.parametrize(("width", "start"), [("95 mm", "260 mm"), ("300 mm", "700 mm")])
@pytest.mark.parametrize(
    "folder", ["quad", "hardware_profiles/quad", "sequences/quad", "made/in/2026/quad"]
)
def test_a_pipe_in_a_project_of_another_robot_is_not_for_the_usual_one(
    width: str, start: str, folder: str, tmp_path: Path
) -> None:
    text = f"{PIPE.replace('120 mm', width)}start: {{at: {start}}}\n"
    pipe = write("sequences/pipes/p.yaml", text)
    (found,) = check_paths(["."]).findings
    assert "pirate_ii" in found.message

    shutil.copytree(NEWT, tmp_path / folder, ignore=shutil.ignore_patterns("[!cpm]*", "p[ae]*"))

    assert check_paths(["."]).findings == ()
    if "made" not in folder:
        assert check_paths([pipe]).findings == ()
    assert check_paths([pipe], Wishes(robot="pirate_ii")).findings == (found,)


def test_a_pipe_in_a_project_that_has_the_usual_robot_is_checked_with_it() -> None:
    write("p.yaml", PIPE.replace("120 mm", "300 mm"))
    shutil.copytree(NEWT, "newt")
    wishes = Wishes(usual_robot="newt")

    assert [each.code for each in check_paths(["."], wishes).findings] == ["pipe.reach"]


def test_a_pipe_that_a_mission_uses_is_checked_with_its_robot_only(tmp_path: Path) -> None:
    shutil.copytree(NEWT, tmp_path / "newt")
    mission = MISSION.replace("start:", "pipe: p.yaml\nstart:")
    write("m.yaml", mission)
    write("p.yaml", PIPE)

    assert check_paths(["."], Wishes(usual_robot=str(NEWT))).findings == ()


def test_an_unknown_robot_or_pipe_is_refused() -> None:
    write("m.yaml")
    for wishes in (Wishes(robot="pirate_3"), Wishes(pipe="straight_13")):
        with pytest.raises(UsageError, match="did you mean"):
            check_paths(["m.yaml"], wishes)


def test_progress_is_reported_before_each_file() -> None:
    write("a.yaml")
    write("b.yaml", PIPE)
    said: list[tuple[int, int, str]] = []

    check_paths(["."], progress=lambda *each: said.append(each))
    assert said == [(0, 2, "b.yaml"), (1, 2, "a.yaml")]


def test_a_fault_of_the_check_is_a_finding_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("lost")

    monkeypatch.setattr(check_file, "check_mission", fail)
    write("a.yaml")
    write("b.yaml", PIPE.replace("120 mm", "120"))

    assert codes(".") == ["check.failed", "quantity"]
    with pytest.raises(RuntimeError):
        check_paths(["."], Wishes(keep_going=False))


def test_of_equal_findings_the_surest_with_the_shortest_story_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    write("a.yaml")
    place = Place("a.yaml", 6, 3)
    same = [
        Finding("step.impossible", Severity.POSSIBLE, place, "m", story=("a",)),
        Finding("step.impossible", Severity.ERROR, place, "m", story=("a", "b")),
        Finding("step.impossible", Severity.ERROR, place, "m", story=("b",)),
        Finding("step.impossible", Severity.ERROR, place, "m"),
    ]
    check = MissionCheck(tuple(same))
    monkeypatch.setattr(check_file, "check_mission", lambda *_, **__: check)

    (finding,) = check_paths(["a.yaml"]).findings
    assert (finding.severity, finding.story) == (Severity.ERROR, ("b",))


HOSTILE = {
    "deep": "mission: m\nphases: " + "[" * 100_000,
    "deep_mapping": "mission: m\nphases:\n" + "".join(" " * n + "a:\n" for n in range(1, 1000)),
    "aliases": "mission: m\nphases: &a [x]\n"
    + "".join(f"k{n}: &b{n} [*a, *a, *a, *a, *a, *a, *a, *a]\n" for n in range(200)),
    "bomb": "mission: m\nphases: {}\na0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    + "".join(f"a{n + 1}: &a{n + 1} [{', '.join([f'*a{n}'] * 9)}]\n" for n in range(10)),
    "large": "mission: m\nphases: {}\n#" + "x" * 10_000_000,
    "long_name": MISSION.replace("go: e", f"go: {'f' * 500_000}"),
    "long_condition": MISSION.replace(
        "go: e", f"wait: [{{when: '{'(' * 50_000}', go: e}}], within: {{time: 1 s, go: e}}"
    ),
    "many_faults": "mission: m\nphases: {}\n" + "".join(f"k{n}: 1\n" for n in range(5_000)),
    "binary": "mission: m\nphases: {}\n\0\0\0",
    "climbing": MISSION.replace("robot: pirate_ii", "robot: ../../../../../../etc"),
    "itself": MISSION.replace("[ClampFront]", "[{call: ./itself.yaml}]"),
    "device": MISSION.replace("start: a", "pipe: /dev/zero\nstart: a"),
}


@pytest.mark.timeout(20)
@pytest.mark.parametrize("name", thorough_but(HOSTILE.keys() - {"many_faults"}, HOSTILE))
def test_a_hostile_file_ends_in_a_clear_finding(name: str) -> None:
    write(f"{name}.yaml", HOSTILE[name])

    report = check_paths([f"{name}.yaml"])
    assert report.fails(Severity.ERROR)
    for finding in report.findings:
        assert finding.code != "check.failed"
        assert len(finding.message) <= 300


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (MISSION.replace("[ClampFront]", "[{call: ./secret.txt}]"), "mission.call"),
        (MISSION.replace("start:", "pipe: ./secret.txt\nstart:"), "mission.pipe"),
    ],
)
def test_nothing_is_shown_of_a_file_that_a_reference_leads_to_and_that_is_not_ours(
    text: str, code: str
) -> None:
    """`call: ../../../../etc/passwd` put its first line into the log of a build server."""
    write("secret.txt", "root:x:0:0:secret words:/root\n")
    write("m.yaml", text)

    report = check_paths(["m.yaml"])

    assert code in {each.code for each in report.findings}
    assert "secret words" not in text_report(report, lambda _, text: text)
    assert "secret words" not in sarif_report(report)


OUTSIDE = MISSION.replace("mission: m", "mission: away").replace("go: e", "go: secret_words")
LEAVING = [
    MISSION.replace("[ClampFront]", "[{call: ../away.yaml}]"),
    MISSION.replace("start:", "pipe: ../away.yaml\nstart:"),
]


@pytest.mark.parametrize("text", LEAVING)
def test_a_reference_out_of_the_project_is_refused_and_nothing_of_the_file_shown(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("away.yaml", OUTSIDE)
    write("own/m.yaml", text)
    monkeypatch.chdir("own")

    report = check_paths(["m.yaml"])

    (finding,) = report.findings
    assert (finding.code, finding.place.file) == ("reference.outside", "m.yaml")
    assert "secret_words" not in str(finding)
    page = text_report(report, lambda _, text: text)
    assert "fix:  Move the file into the project, or check with `--outside`." in page


def test_a_reference_may_leave_the_project_where_that_is_wanted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    write("away.yaml", OUTSIDE)
    write("own/m.yaml", LEAVING[0])
    monkeypatch.chdir("own")

    (finding, *_) = check_paths(["m.yaml"], Wishes(outside=True)).findings

    assert "secret_words" in finding.message


@pytest.mark.parametrize("mark", ["hardware_profiles", "sequences", ".git"])
def test_a_project_reaches_up_to_the_folder_that_holds_its_parts(
    mark: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(f"{mark}/keep.txt", "")
    write("parts/part.yaml", MISSION.replace("mission: m", "mission: part"))
    write("own/m.yaml", MISSION.replace("[ClampFront]", "[{call: ../parts/part.yaml}]"))
    monkeypatch.chdir("own")

    assert check_paths(["m.yaml"]).findings == ()


def test_a_link_does_not_lead_a_reference_out_of_the_project(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    write("away.yaml", OUTSIDE)
    write("own/m.yaml", MISSION.replace("[ClampFront]", "[{call: ./link.yaml}]"))
    monkeypatch.chdir("own")
    Path("link.yaml").symlink_to("../away.yaml")

    assert codes("m.yaml") == ["reference.outside"]


def test_a_chart_is_not_taken_from_outside_the_project(monkeypatch: pytest.MonkeyPatch) -> None:
    write("secret.txt", "In('secret words')\n")
    write("own/robot/profile.yaml", (NEWT / "profile.yaml").read_text("utf-8"))
    swap(Path("own/robot/profile.yaml"), ("chart: chart.yaml", "chart: ../../secret.txt"))
    monkeypatch.chdir("own")

    (finding,) = check_paths(["robot"]).findings

    assert finding.code == "reference.outside"
    assert "secret words" not in str(finding)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_called_mission_is_known_however_its_lines_end(end: str) -> None:
    text = MISSION.replace("go: e", "goo: e").replace("\n", end)
    Path("part.yaml").write_bytes(text.encode())
    write("m.yaml", MISSION.replace("[ClampFront]", "[{call: ./part.yaml}]"))

    (finding,) = check_paths(["m.yaml"]).findings

    assert (finding.code, finding.place.file) == ("unknown-key", "part.yaml")


def test_what_is_wrong_with_a_called_mission_is_still_shown() -> None:
    write("part.yaml", MISSION.replace("go: e", "go: nowhere"))
    write("m.yaml", MISSION.replace("[ClampFront]", "[{call: ./part.yaml}]"))

    (finding, *_) = check_paths(["m.yaml"]).findings

    assert finding.place.file == "part.yaml"
    assert "nowhere" in finding.excerpt

"""What a check makes of missions that somebody runs for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from checking.small_missions import MISSION
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Severity
from pirate_sm.checking.reports.check_report import CheckReport, Nearly, Rehearsal, RehearsedRun
from pirate_sm.checking.reports.text import text_report
from pirate_sm.core.loading import LoadedMission

GOOD = RehearsedRun(0, "succeeded", "ok", 3.0)
BAD = RehearsedRun(1, "failed", "no bend", 7.25)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.yaml").write_text(MISSION, encoding="utf-8")
    return tmp_path / "m.yaml"


def checked(*runs: RehearsedRun, nearly: tuple[Nearly, ...] = ()) -> CheckReport:
    def rehearse(loaded: LoadedMission, path: Path) -> Rehearsal:
        assert loaded.mission.mission == "m"
        return Rehearsal(path.name, runs, nearly)

    return check_paths(["m.yaml"], Wishes(rehearse=rehearse))


def told(report: CheckReport) -> list[str]:
    return text_report(report, lambda _, text: text).splitlines()


def test_a_mission_that_succeeds_has_no_finding(file: Path) -> None:
    report = checked(GOOD)

    assert report.findings == ()
    assert report.rehearsals == (Rehearsal("m.yaml", (GOOD,)),)
    assert told(report)[1] == "  m.yaml: succeeded after 3.0 s: ok"


def test_a_mission_that_does_not_is_an_error_at_its_name(file: Path) -> None:
    (finding,) = checked(BAD).findings

    assert (finding.code, finding.severity) == ("rehearsal.failed", Severity.ERROR)
    assert str(finding.place) == "m.yaml:2:10"
    assert finding.message == "in the simulator it does not succeed: no bend (after 7.2 s)"


def test_of_several_runs_it_is_said_which_did_not(file: Path) -> None:
    report = checked(GOOD, BAD, RehearsedRun(2, "fault", "clamp.lost: gone", 5.0))
    (finding,) = report.findings

    assert finding.message.endswith("no bend (after 7.2 s); 2 of 3 runs, with the seeds 1, 2")
    assert "  m.yaml: 1 of 3 runs succeeded, after 3.0 s to 3.0 s" in told(report)


def test_it_can_be_allowed(file: Path) -> None:
    allowed = "mission: m  # pirate: allow rehearsal.failed: it is meant to fail\n"
    file.write_text(MISSION.replace("mission: m\n", allowed), encoding="utf-8")

    assert checked(BAD).open == ()


def test_a_mission_with_an_error_is_not_run(file: Path) -> None:
    file.write_text(MISSION.replace("[ClampFront]", "[DriveForward]"), encoding="utf-8")
    (rehearsal,) = checked(GOOD).rehearsals

    assert (rehearsal.runs, rehearsal.skipped) == ((), "the check has found errors in it")


def test_a_mission_whose_error_is_allowed_is_run(file: Path) -> None:
    wrong = "[ClampFront, ClampFront], go: e}  # pirate: allow step.unneeded: so"
    text = MISSION.replace("[ClampFront], go: e}", wrong).replace("e: {s", "e: {s")
    file.write_text(text + "on_failure: e\n", encoding="utf-8")

    assert [each.runs for each in checked(GOOD).rehearsals] == [(GOOD,)]


def test_the_three_closest_calls_are_reported(file: Path) -> None:
    nearly = tuple(Nearly(f"call {n}", 0.9 - n / 10, 1.0, 4) for n in range(5))

    assert told(checked(GOOD, nearly=nearly))[2:5] == [
        "     90% at 1.0 s: call 0", "     80% at 1.0 s: call 1", "     70% at 1.0 s: call 2",
    ]  # fmt: skip
    assert told(checked(GOOD, GOOD, nearly=nearly))[2] == "     90% at 1.0 s, seed 4: call 0"


def test_without_the_wish_nothing_is_run(file: Path) -> None:
    assert check_paths(["m.yaml"]).rehearsals == ()

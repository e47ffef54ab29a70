"""`pirate campaign`, and reports and comparisons of what it leaves."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from html import unescape
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core import library
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.campaign_model import MOST_SEEDS
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import recording_name, stored
from pirate_sm.lab.campaign.crew import Done
from pirate_sm.lab.campaign.plan import mark_of
from pirate_sm.lab.campaign.store import Store
from pirate_sm.lab.experiments import needed_extras

from ..conftest import ROOT

TRIAL = """\
format: 1
campaign: trial
missions: [{mission: enter_2d, name: enter}]
defects: [none, stale_repeats]
seeds: 0..59
expect: {success: ">= 80 %"}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "trial.yaml"
    path.write_text(TRIAL, "utf-8")
    return path


@pytest.fixture
def filled(file: Path, tmp_path: Path) -> Any:
    """Results of all runs, of which the first ones of the second cell have failed."""

    def fill(name: str, failed: int) -> Path:
        plan, store = read_campaign(file, check=False), Store(tmp_path / name)
        store.begin(mark_of(plan))
        for cell, failing in zip(plan.cells, (0, failed), strict=True):
            store.add(
                RunRow(cell.key, seed, "failed", "failed", "Lost", False, "", 9.0, 0.1, 0.0, 0.0)
                if seed < failing
                else RunRow(cell.key, seed, "succeeded", "passed", "", True, "", 9.0, 0.1, 0.0, 0.0)
                for seed in cell.seeds
            )
        store.close()
        return tmp_path / name

    return fill


@pytest.mark.parametrize("module", ["pyarrow", "distributed"])
def test_a_missing_package_is_named_before_the_missions_are_checked(
    pirate: Any, file: Path, monkeypatch: pytest.MonkeyPatch, module: str
) -> None:
    def checked(*_: Any, **__: Any) -> None:
        raise AssertionError("the missions were checked")

    monkeypatch.setattr("pirate_sm.cli.commands.campaign.read_campaign", checked)
    monkeypatch.setitem(sys.modules, module, None)

    result = pirate("campaign", file)

    assert result.exit_code == 2
    assert f"needs {module}, which is not installed" in result.stderr
    assert "pirate-sm[campaign]" in result.stderr


def test_a_campaign_that_is_complete_prints_its_table_again(
    pirate: Any, file: Path, filled: Any
) -> None:
    results = filled("results", 5)
    result = pirate("campaign", file, "-o", results, "--resume", "--record", "none", "--no-check")

    assert result.exit_code == 0
    assert "enter: stale_repeats       55 of 60  91.7%" in result.stdout
    assert "5 × failed: Lost (seeds 0, 1, 2, 3, 4)" in result.stdout
    assert "pirate run enter_2d --seed 0 --speed max --defect stale_repeats" in result.stdout


def test_going_on_with_one_cell_keeps_the_others_in_the_report(
    pirate: Any, file: Path, filled: Any
) -> None:
    results = filled("results", 5)
    before = json.loads((results / "campaign.json").read_text("utf-8"))
    words = ("campaign", file, "-o", results, "--resume", "--record", "none", "--no-check")

    one = pirate(*words, "--cell", "enter: stale_repeats")

    assert one.exit_code == 0
    assert "no defect" not in one.stdout
    assert json.loads((results / "campaign.json").read_text("utf-8")) == before


def test_less_than_expected_is_exit_code_1_in_every_format(
    pirate: Any, file: Path, filled: Any
) -> None:
    words = ("campaign", file, "-o", filled("results", 20), "--resume", "--record", "none")
    text, data, junit = (
        pirate(*words, "--no-check", "--format", form) for form in ("text", "json", "junit")
    )

    assert {text.exit_code, data.exit_code, junit.exit_code} == {1}
    assert "BELOW EXPECTED: success" in text.stdout
    read = json.loads(data.stdout)
    assert [cell["missed"] for cell in read["cells"]] == [[], ["success"]]
    assert 'failures="1"' in junit.stdout


def test_results_that_are_there_are_not_touched_without_resume(
    pirate: Any, file: Path, filled: Any
) -> None:
    result = pirate("campaign", file, "-o", filled("results", 5), "--no-check")

    assert result.exit_code == 2
    assert "continue with --resume" in result.stderr


def test_a_folder_of_something_else_is_not_written_to(
    pirate: Any, file: Path, tmp_path: Path
) -> None:
    result = pirate("campaign", file, "-o", tmp_path, "--no-check")

    assert result.exit_code == 2
    assert "has no results of a campaign" in result.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--cell", "leave"], "there is no cell 'leave'"),
        (["--workers", "2", "--scheduler", "tcp://a:1"], "exclude each other"),
        (["--workers", "9999"], "4 for each processor; more only take memory"),
        (["--seeds", "0"], "expected at least 1"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    pirate: Any, file: Path, words: list[str], message: str
) -> None:
    result = pirate("campaign", file, "--no-check", *words)

    assert result.exit_code == 2
    assert message in result.stderr


def test_a_mission_needs_a_number_of_seeds(pirate: Any) -> None:
    result = pirate("campaign", "enter_2d")

    assert result.exit_code == 2
    assert "say how often it runs with --seeds" in result.stderr


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("tube.yaml", "format: 1\npipe: tube\ndiameter: 120 mm\n", "it is a pipe"),
        ("list.yaml", "- a\n", "it has neither `campaign` and `missions` nor"),
    ],
)
@pytest.mark.parametrize("seeds", [(), ("--seeds", "1")])
def test_a_file_of_another_kind_is_no_campaign(
    pirate: Any, tmp_path: Path, name: str, text: str, said: str, seeds: tuple[str, ...]
) -> None:
    file = tmp_path / name
    file.write_text(text, "utf-8")
    result = pirate("campaign", file, *seeds)

    assert result.exit_code == 2
    assert f"{file} is neither a campaign nor a mission: {said}" in result.stderr


def test_results_need_a_folder_and_a_number_of_seeds_that_can_be_counted(
    pirate: Any, tmp_path: Path
) -> None:
    taken = tmp_path / "taken"
    taken.touch()
    result = pirate("campaign", "enter_2d", "--seeds", "1", "--output", taken)
    assert result.exit_code == 2
    assert f"'{taken}' is a file: name a folder for the results with --output" in result.stderr
    result = pirate("campaign", "enter_2d", "--seeds", "9" * 20)
    assert result.exit_code == 2
    assert f"Invalid value for '--seeds': expected at most {MOST_SEEDS}" in result.stderr


def test_a_new_campaign_can_be_run(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = pirate("new", "campaign", "first")

    assert result.exit_code == 0
    assert [cell.name for cell in read_campaign(Path("first.yaml"), check=False).cells] == [
        "mitre_bend: no defect",
        "mitre_bend: wheels_3_4_dead",
    ]
    assert (tmp_path / "campaign.schema.json").exists()


def test_a_new_campaign_says_how_to_get_what_runs_it(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "pip install" not in pirate("new", "campaign", "there").stdout
    (tmp_path / "campaign.schema.json").unlink()
    monkeypatch.setattr(needed_extras, "find_spec", lambda name: None)
    result = pirate("new", "campaign", "missing")

    assert result.exit_code == 0
    assert "run it with: pirate campaign missing.yaml" in result.stdout
    assert "pip install 'pirate-sm[campaign]'" in result.stdout


def test_the_report_of_results_is_a_page_in_their_folder(pirate: Any, filled: Any) -> None:
    results = filled("results", 5)
    result = pirate("report", results)

    assert result.exit_code == 0
    assert "55 of 60" in (results / "index.html").read_text("utf-8")


@pytest.mark.thorough
def test_a_campaigns_page_links_to_the_reports_of_its_recorded_runs(
    pirate: Any, filled: Any, tmp_path: Path
) -> None:
    results = filled("results", 1)
    tally = stored(results).tallies[1]
    recorded = results / "recordings" / recording_name(tally, 0)
    recorded.parent.mkdir()
    words = ("--seed", "0", "--speed", "max", "--quiet", "--record", recorded)
    assert pirate("run", "enter_2d", *words).exit_code == 0
    pages = pirate("report", results), pirate("report", results, "--output", tmp_path / "p.html")

    assert [each.exit_code for each in pages] == [0, 0]
    assert recorded.with_suffix(".html").is_file()
    link = f"recordings/{recorded.with_suffix('.html').name}"
    assert f'<a href="{link}">report</a>' in (results / "index.html").read_text("utf-8")
    assert f'"results/{link}">report</a>' in (tmp_path / "p.html").read_text("utf-8")


def test_two_campaigns_are_compared(pirate: Any, filled: Any) -> None:
    before, after, alike = filled("before", 2), filled("after", 30), filled("alike", 3)
    worse, same = pirate("compare", before, after), pirate("compare", before, alike)

    assert (worse.exit_code, same.exit_code) == (1, 0)
    assert "B is worse than A" in worse.stdout
    assert "McNemar" in worse.stdout
    assert "28 lost in B: seeds 2, 3, 4" in worse.stdout
    assert "B is not significantly worse than A" in same.stdout


@pytest.fixture
def damaged(filled: Any) -> Path:
    """Results of all runs, of which one of two files is damaged: the second cell's."""
    results: Path = filled("results", 5)
    rows = [row for rows in Store(results).read() for row in rows]
    (file,) = (results / "results").glob("*.parquet")
    file.unlink()
    store = Store(results, clock=count(0, 10).__next__)  # so late that all is written at once
    store.add(rows[:75])
    store.add(rows[75:])
    (results / "results" / "0-00000002.parquet").write_bytes(b"PAR1")
    return results


def test_a_report_names_damaged_results_and_what_is_missing_in_the_table(
    pirate: Any, damaged: Path
) -> None:
    result = pirate("report", damaged)
    page = (damaged / "index.html").read_text("utf-8")

    assert result.exit_code == 1
    for said in (result.stderr, unescape(page)):
        assert "0-00000002.parquet' is damaged (" in said
        assert "its runs do not count; the campaign's command with --resume repeats those" in said
        assert "no result for 45 of 60 seeds, the first is 15" in said
    assert "enter: stale_repeats: not complete" in result.stderr
    assert "75 runs of 2 cells: 1 not complete" in page


def test_a_comparison_with_damaged_results_names_them(
    pirate: Any, filled: Any, damaged: Path
) -> None:
    result = pirate("compare", filled("before", 5), damaged)

    assert result.exit_code == 2
    assert "0-00000002.parquet' is damaged (" in result.stderr


def test_damaged_results_are_set_aside_and_their_runs_repeated(
    pirate: Any, file: Path, damaged: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pirate_sm.cli.commands.campaign.connected", lambda *_: nullcontext(ALL))
    result = pirate("campaign", file, "-o", damaged, "--resume", "--record", "none", "--no-check")

    assert result.exit_code == 0, result.stderr
    assert "warning: '" in result.stderr
    assert "0-00000002.parquet' is damaged (" in result.stderr
    assert "runs that are missing are repeated" in result.stderr
    assert "55 of 60  91.7%" in result.stdout
    assert f"results in {damaged}" in result.stdout
    assert pirate("report", damaged).exit_code == 0


class All:
    """A crew whose every run passes."""

    room = 8

    def __init__(self) -> None:
        self.chunks: list[Chunk] = []

    def submit(self, chunk: Chunk) -> None:
        self.chunks.append(chunk)

    def wait(self, within_s: float) -> Sequence[Done]:
        chunks, self.chunks = self.chunks, []
        return [
            Done(
                each,
                [
                    RunRow(each.cell, seed, "succeeded", "passed", "", True, "", 9.0, 0.1, 0.0, 0.0)
                    for seed in each.seeds
                ],
            )
            for each in chunks
        ]

    def doing(self, work: object) -> All:
        return self


ALL = All()


def test_a_damaged_description_is_rewritten_by_resume(pirate: Any, file: Path, filled: Any) -> None:
    results = filled("results", 5)
    (results / "campaign.json").write_text('{"campaign": "trial"}', "utf-8")
    for command in (("report", results), ("compare", results, results)):
        result = pirate(*command)
        assert result.exit_code == 2
        assert "campaign.json' is damaged (`format` is missing)" in result.stderr
        assert f"with --resume and --output {results} rewrites it" in result.stderr

    words = ("campaign", file, "-o", results, "--resume", "--record", "none", "--no-check")
    result = pirate(*words)
    assert result.exit_code == 0
    assert "campaign.json' is damaged (`format` is missing): it is rewritten" in result.stderr
    assert pirate("report", results).exit_code == 0


def test_results_of_another_campaign_are_not_gone_on_with(
    pirate: Any, tmp_path: Path, filled: Any
) -> None:
    results = filled("results", 5)
    other = tmp_path / "other.yaml"
    other.write_text(TRIAL.replace("trial", "other").replace("name: enter", "name: go"), "utf-8")
    before = (results / "campaign.json").read_bytes()
    words = ("-o", results, "--resume", "--no-check")

    result = pirate("campaign", other, *words)
    assert result.exit_code == 2
    assert (
        f"'{results}' has the results of the campaign 'trial' (enter: no defect, "
        "enter: stale_repeats), and this is 'other' (go: no defect, go: stale_repeats): "
        "name another folder with --output"
    ) in result.stderr
    (results / "campaign.json").write_text('{"campaign": "trial"}', "utf-8")
    assert "this is 'other'" in pirate("campaign", other, *words).stderr
    (results / "campaign.json").write_bytes(before)
    assert pirate("campaign", "enter_2d", "--seeds", "1", *words).exit_code == 2


def test_results_that_do_not_count_any_more_are_named(
    pirate: Any, file: Path, filled: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pirate_sm.cli.commands.campaign.connected", lambda *_: nullcontext(ALL))
    results = filled("results", 5)
    file.write_text(TRIAL + "jitter: {start: 1 mm}\n", "utf-8")
    result = pirate("campaign", file, "-o", results, "--resume", "--record", "none", "--no-check")

    assert result.exit_code == 0
    assert "which are not used: enter: no defect, enter: stale_repeats" in result.stderr


@pytest.mark.parametrize(
    ("stem", "name"), [("patrol", "patrol"), ("my patrol-2", "my_patrol_2"), ("2d", "mission_2d")]
)
def test_a_campaign_of_one_mission_has_its_name(tmp_path: Path, stem: str, name: str) -> None:
    mission = tmp_path / f"{stem}.yaml"
    mission.write_text(library.find_mission("enter_2d").read_text("utf-8"), "utf-8")

    assert read_campaign(mission, range(3), check=False).name == name


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_campaign_that_is_stopped_while_workers_start_ends_and_says_how_to_go_on(
    name: str, status: int, tmp_path: Path
) -> None:
    code = f"""
import signal
import distributed
class Slow(distributed.LocalCluster):
    def __init__(self, *given, **more):
        signal.raise_signal(signal.{name})
        super().__init__(*given, **more)
distributed.LocalCluster = Slow
from pirate_sm.cli.start import main
main()
"""
    words = ["campaign", "enter_2d", "--seeds", "50", "--workers", "1", "--no-check"]
    ended = subprocess.run(
        [sys.executable, "-c", code, *words, "-o", "results"],
        cwd=tmp_path, env=dict(os.environ) | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=60,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip

    assert (ended.returncode, ended.stdout) == (status, "")
    assert ended.stderr.endswith("; results so far are in 'results': continue with --resume\n")
    assert ended.stderr.count("\n") == 1

"""The page and the JUnit report of a campaign."""

from __future__ import annotations

import shlex
from pathlib import Path
from xml.etree.ElementTree import fromstring

from pirate_sm.lab.campaign.campaign_model import Expectation
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Conductor, recording_name, stored
from pirate_sm.lab.campaign.page import page_of
from pirate_sm.lab.campaign.plan import mark_of
from pirate_sm.lab.campaign.result_suite import as_junit
from pirate_sm.lab.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.lab.campaign.store import Store

from .rows import Hasty, cell, plan, row


def result(folder: Path) -> CampaignResult:
    wanted = plan(cell("a <b>", range(60), Expectation(success=0.99)), cell("c", range(40)))
    store = Store(folder)
    store.begin(mark_of(wanted))
    conductor = Conductor(wanted, store)
    conductor.conduct(Hasty(1))
    store.close()
    first = conductor.tallies[0].causes["failed", "Holding"].seeds[0]
    store.keep(recording_name(conductor.tallies[0], first), b"recorded")
    return result_of(wanted, conductor.results, folder)


def test_the_page_loads_nothing_and_links_to_recordings(tmp_path: Path) -> None:
    page = page_of(result(tmp_path), "recordings")

    assert "a &lt;b&gt;" in page
    assert "a <b>" not in page
    assert page.count('<td class="bad"') == 1
    assert page.count('href="recordings/a_b_key_a') == 1
    assert "100 runs of 2 cells: 1 not as expected." in page
    assert "http" not in page.replace('http-equiv="Content', "")


def test_success_is_drawn_against_what_runs_have_drawn_with_reports_of_failures(
    tmp_path: Path,
) -> None:
    def drew(chunk: Chunk, seed: int) -> RunRow:
        far = seed % 40 < 20
        drawn = {"start_m": 0.015 if far else -0.015}
        return row(chunk.cell, seed, "failed" if far else "passed", time_s=seed)._replace(
            drawn=drawn
        )

    wanted, store = plan(cell("a", range(80))), Store(tmp_path)
    store.begin(mark_of(wanted))
    conductor = Conductor(wanted, store)
    conductor.conduct(Hasty(1, result=drew))
    store.close()
    store.keep(recording_name(conductor.tallies[0], 0), b"recorded")
    (only,) = result_of(wanted, stored(tmp_path).tallies, tmp_path).cells
    (factor,) = only.factors

    assert (factor.name, factor.unit, factor.edges[0], factor.edges[-1]) == (
        *("start_m", "m"),
        *(-0.02, 0.02),
    )
    assert [(n, factor.runs[n], factor.passed[n]) for n in range(10) if factor.runs[n]] == [
        (1, 40, 40),
        (8, 40, 0),
    ]
    assert only.took is not None
    assert (only.took.edges_s[0], only.took.edges_s[-1]) == (0.0, 79.0)
    assert (sum(only.took.passed), sum(only.took.others)) == (40, 40)
    found = result_of(wanted, conductor.results, tmp_path)
    page = page_of(found, "recordings", reports={only.causes[0].recording: "recordings/a.html"})
    assert 'aria-label="Success against start"' in page
    assert 'aria-label="Mission time"' in page
    assert 'seed 0: <a href="recordings/a.html">report</a>' in page
    assert found.as_data()["cells"][0]["values"]["mission"] == "mitre_bend"


def test_junit_has_a_failure_for_each_cell_below_its_expectation(tmp_path: Path) -> None:
    root = fromstring(as_junit(result(tmp_path)))

    assert (root.attrib["tests"], root.attrib["failures"]) == ("2", "1")
    (failure,) = root.iter("failure")
    assert failure.attrib["message"] == "success"
    assert "pirate run mitre_bend --seed" in (failure.text or "")


def without_runs(folder: Path) -> CampaignResult:
    wanted = plan(cell("a", range(60)), cell("b", range(40)))
    store = Store(folder)
    store.begin(mark_of(wanted))
    conductor = Conductor(wanted, store)
    conductor.tallies[0].add(row("key_a", seed) for seed in (0, 1, 3))
    store.close()
    return result_of(wanted, conductor.results, folder)


def test_a_cell_without_runs_has_no_share_in_any_form(tmp_path: Path) -> None:
    read = without_runs(tmp_path)
    page, text, data = page_of(read, "recordings"), as_text(read), read.as_data()

    assert data["cells"][1]["least"] is None
    assert data["cells"][1]["most"] is None
    assert ">no runs</a>" in page
    assert " 0.0%" not in page + text
    assert text.splitlines()[3].split() == ["b", "no", "runs"]


def test_a_campaign_that_was_interrupted_has_an_error_in_junit_for_each_cell_without_results(
    tmp_path: Path,
) -> None:
    """It had neither an error nor a failure, so that only the exit code showed it."""
    suite = fromstring(as_junit(without_runs(tmp_path)))

    assert [each.attrib["message"][:30] for each in suite.iter("error")] == [
        "not complete: no result for 57",
        "not complete: no result for 40",
    ]
    assert [each.attrib["errors"] for each in suite.iter("testsuite")] == ["2"]


def test_what_is_missing_of_a_cell_is_said_and_is_not_as_expected(tmp_path: Path) -> None:
    read = without_runs(tmp_path)
    page, text = page_of(read, "recordings"), as_text(read)

    said = "not complete: no result for 57 of 60 seeds, the first is 2; later ones do not count"
    assert said in page
    assert said in text
    assert "2 runs of 2 cells: 2 not complete\n" in text
    assert not read.good
    assert read.as_data()["cells"][0]["first_without"] == 2


def test_the_table_says_where_results_and_recordings_are_for_a_shell(tmp_path: Path) -> None:
    folder = tmp_path / "my results"
    text = as_text(result(folder))

    assert text.splitlines()[-1] == f"results in '{folder}'"
    (recorded,) = (line.strip() for line in text.splitlines() if "recorded in" in line)
    (place,) = shlex.split(recorded.removeprefix("recorded in "))
    assert Path(place).read_bytes() == b"recorded"

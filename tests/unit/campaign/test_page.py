"""The page and the JUnit report of a campaign."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

from pirate_sm.campaign.conductor import Conductor
from pirate_sm.campaign.junit import as_junit
from pirate_sm.campaign.page import page_of
from pirate_sm.campaign.plan import mark_of
from pirate_sm.campaign.recorded_run import recording_name
from pirate_sm.campaign.results import CampaignResult, result_of
from pirate_sm.campaign.store import Store
from pirate_sm.model.campaign import Expectation

from .rows import Hasty, cell, plan


def result(folder: Path) -> CampaignResult:
    wanted = plan(cell("a <b>", range(60), Expectation(success=0.99)), cell("c", range(40)))
    store = Store(folder)
    store.begin(mark_of(wanted))
    conductor = Conductor(wanted, store)
    conductor.conduct(Hasty(1))
    store.close()
    first = conductor.tallies[0].causes["failed", "Holding"].seeds[0]
    store.keep(recording_name(conductor.tallies[0], first), b"recorded")
    return result_of(wanted, conductor.results, store.recordings)


def test_the_page_loads_nothing_and_links_to_recordings(tmp_path: Path) -> None:
    page = page_of(result(tmp_path), "recordings")

    assert "a &lt;b&gt;" in page
    assert "a <b>" not in page
    assert page.count('<td class="bad"') == 1
    assert page.count('href="recordings/a_b_key_a') == 1
    assert "http" not in page.replace('http-equiv="Content', "")


def test_junit_has_a_failure_for_each_cell_below_its_expectation(tmp_path: Path) -> None:
    root = fromstring(as_junit(result(tmp_path)))

    assert (root.attrib["tests"], root.attrib["failures"]) == ("2", "1")
    (failure,) = root.iter("failure")
    assert failure.attrib["message"] == "success"
    assert "pirate run mitre_bend --seed" in (failure.text or "")

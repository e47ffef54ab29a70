"""The page of a mission shows how far it holds, by results that are of these very files only."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from pirate_sm.lab.campaign import campaign_file
from pirate_sm.lab.campaign import plan as plan_module
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Conductor
from pirate_sm.lab.campaign.known_margins import known_margins
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.store import MARK, Store
from pirate_sm.running.wiring import Order
from pirate_sm.views.report.mission_page import mission_page

from .rows import Hasty, row

NEWT = Path(__file__).resolve().parents[3] / "robots" / "newt"
ASKED = {"margins": {"factors": {"friction": "0.1..0.9"}, "runs": 60}}


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    """A mission whose robot and pipe may be edited."""
    folder = tmp_path / "newt"
    shutil.copytree(NEWT, folder)
    return folder / "patrol.yaml"


def slippery(chunk: Chunk, seed: int) -> RunRow:
    """Fail below a friction of 0.3."""
    grips = float(chunk.order.numbers.get("pipe.friction", "0.5")) >= 0.3
    return row(chunk.cell, seed, "passed" if grips else "failed", "it <slips>")


def keep(plan: CampaignPlan, folder: Path, *, whole: bool = True) -> Path:
    """Keep the results of a search; if it is not whole, those of the mission itself only."""
    store = Store(folder)
    store.begin(mark_of(plan))
    if whole:
        Conductor(plan, store).conduct(Hasty(0, result=slippery))
    else:
        store.add([row(plan.cells[0].key, seed) for seed in plan.cells[0].seeds])
    store.close()
    return folder


@pytest.fixture
def results(mission: Path, tmp_path: Path) -> Path:
    return keep(read_campaign(mission, check=False, more=ASKED), tmp_path / "results")


def page(mission: Path, folder: Path, robot: str | None = None, pipe: str | None = None) -> str:
    order = Order(str(mission), robot=robot, pipe=pipe)
    return mission_page(mission, robot, pipe, lambda: known_margins(folder, order))


def test_the_envelope_stands_between_the_pipe_and_the_file(mission: Path, results: Path) -> None:
    shown = page(mission, results)

    assert 'class="margins"' in shown
    assert "holds from 0.3031 to 0.9" in shown
    assert "it &lt;slips&gt;" in shown
    assert "another version" not in shown
    places = [shown.index(f"<h2>{each}") for each in
              ("The pipe, to scale", "How far it holds", "patrol.yaml")]  # fmt: skip
    assert places == sorted(places)


@pytest.mark.parametrize("file", ["patrol.yaml", "elbow.yaml", "profile.yaml", "chart.yaml"])
def test_nothing_is_shown_of_results_of_an_earlier_text(
    mission: Path, results: Path, file: str
) -> None:
    edited = mission.with_name(file)
    edited.write_text(edited.read_text("utf-8") + "# another line\n", "utf-8")

    shown = page(mission, results)

    assert "are of an earlier text of the mission, its robot or its pipe" in shown
    assert 'class="margins"' not in shown


def test_nothing_is_shown_of_results_in_another_pipe_or_of_another_mission(
    mission: Path, results: Path
) -> None:
    other = mission.with_name("tunnel.yaml")
    other.write_text(mission.with_name("elbow.yaml").read_text("utf-8") + "# wider\n", "utf-8")

    for shown in (
        page(mission, results, pipe=str(other)),
        page(mission.with_name("take_hold.yaml"), results),
    ):
        assert "are of another mission, another robot or another pipe" in shown
        assert 'class="margins"' not in shown


def test_the_same_files_in_another_folder_have_the_same_envelope(
    mission: Path, results: Path, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    moved = mission.parent.rename(elsewhere / "newt") / mission.name
    assert 'class="margins"' in page(moved, results)


def test_results_of_another_version_of_the_program_say_so(
    mission: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as before:
        for module in (campaign_file, plan_module):
            before.setattr(module, "code_version", lambda: "0.1+earlier")
        plan = read_campaign(mission, check=False, more=ASKED)

    shown = page(mission, keep(plan, tmp_path / "earlier"))

    assert "Found by 0.1+earlier, another version of this program" in shown
    assert 'class="margins"' in shown


def test_a_search_that_was_interrupted_says_what_is_missing(mission: Path, tmp_path: Path) -> None:
    plan = read_campaign(mission, check=False, more=ASKED)

    shown = page(mission, keep(plan, tmp_path / "begun", whole=False))

    assert "not complete: 8 values of its factors have no result yet" in shown


def _no_margins(folder: Path, plan: CampaignPlan) -> None:
    keep(replace(plan, margins=None), folder, whole=False)


def _damaged(folder: Path, plan: CampaignPlan) -> None:
    keep(plan, folder)
    (folder / MARK).write_text("{", "utf-8")


def _newer(folder: Path, plan: CampaignPlan) -> None:
    keep(plan, folder)
    mark = json.loads((folder / MARK).read_text("utf-8"))
    (folder / MARK).write_text(json.dumps({**mark, "format": 99}), "utf-8")


@pytest.mark.parametrize(
    ("spoil", "said"),
    [(_no_margins, ""), (_damaged, "is damaged"), (_newer, "have format 99")],
)
def test_results_that_say_nothing_of_it_leave_the_page_as_it_is(
    mission: Path, tmp_path: Path, spoil: Callable[[Path, CampaignPlan], None], said: str
) -> None:
    spoil(tmp_path / "other", read_campaign(mission, check=False, more=ASKED))

    shown = page(mission, tmp_path / "other")

    assert said in shown
    assert ("How far it holds" in shown) == bool(said)
    assert "The pipe, to scale" in shown


def test_without_the_package_for_results_the_page_says_how_to_install_it(
    mission: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pirate_sm.lab.campaign.known_margins.find_spec", lambda _: None)
    assert "pirate-sm[campaign]" in page(mission, results)

"""`pirate margins`: what its options say, and what is wrong with them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.lab.campaign.campaign_file import check_campaign, read_campaign
from pirate_sm.lab.campaign.margin_factors import factors_around
from pirate_sm.lab.campaign.margins_model import Margins
from pirate_sm.running.wiring import Order

PAGE = Path(__file__).parents[4] / "docs" / "margins.md"
FILE = """\
format: 1
campaign: trial
missions: [drive_on]
margins:
  factors: {FACTORS}
  EXPECTS
"""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--factor", "frction"], "there is no factor 'frction': did you mean 'friction'?"),
        (["--factor", "friction=0.9..1"], "must have the value of the files, 0.5"),
        (["--factor", "tilt=0m..1m"], "tilt: "),
        (["--factor", "gamma_9_sticks:after=0s..9s"], "there is no defect 'gamma_9_sticks'"),
        (["--factor", "gamma_2_sticks:by=1..2"], "takes no number 'by'"),
        (["--factor", "gamma_2_sticks:after"], "say from where to where"),
        (["--factor", "friction", "--factor", "friction"], "--factor gives 'friction' twice"),
        (["--pair", "friction"], "expected two names"),
        (["--pair", "friction,speed"], "there is no factor 'speed'"),
        (["--expect", "friction=0.3"], "expected a bound such as 'friction>=0.35'"),
        (["--expect", "friction>=7"], "expected a bound from 0.05 to 1, got '7'"),
        (["--expect", "friction>=0.8"], "'>= 0.8' says nothing, as the margin begins at 0.5"),
        (["--expect", "friction<=0.2"], "write '>= 0.2'"),
        (
            ["--runs", "30"],
            "with 30 runs no value can be sure enough to hold, or to fail, at a "
            "share of 90 %, which takes 42: give at least 42",
        ),
        (["--share", "98 %"], "give at least 217"),
        (["--share", "99.9 %"], "ask for another share"),
        (["--factor", "tilt=-100deg..90deg"], "pipe.tilt: expected from -1.5"),
        (["--factor", "diameter=100mm..200mm"], "expected less than 25% more or less"),
        (["--factor", "motors.bend.stall_torque=-1Nm..9Nm"], "motors.bend.stall_torque"),
        (["--share", "120 %"], "--share 120 %: expected more than 0 and at most 100 %"),
        (["--confidence", "100 %"], "--confidence 100 %: no number of runs shows that"),
        (["--falsify", "--within", "0"], "--within 0: expected more than 0"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(
    pirate: Any, tmp_path: Path, words: list[str], said: str
) -> None:
    result = pirate("margins", "drive_on", "--no-check", "-o", tmp_path / "results", *words)

    assert result.exit_code == 2
    assert said in " ".join(result.stderr.split())
    assert "Traceback" not in result.stderr


def plan_of(tmp_path: Path, factors: str, expects: str = "") -> Any:
    file = tmp_path / "trial.yaml"
    file.write_text(FILE.replace("{FACTORS}", factors).replace("EXPECTS", expects), "utf-8")
    return read_campaign(file, check=False)


def test_a_campaign_file_names_factors_with_ranges_and_all_defects_that_take_a_number(
    tmp_path: Path,
) -> None:
    plan = plan_of(tmp_path, "{friction: 0.2..0.8, tilt: usual, 'each:after': 0 s..4 s}")
    around = {each.name: each for each in plan.cells[0].around}

    assert (around["friction"].low, around["friction"].high) == (0.2, 0.8)
    assert around["tilt"].written(around["tilt"].high) == "45 deg"
    assert around["gamma_2_sticks:after"].nominal == 4.0
    assert "gamma_1_zero_jumps:after" in around
    assert "messages_lost:after" in around
    assert len(plan.cells[0].seeds) == plan.margins.runs == 200


def test_usual_ranges_end_where_a_pipe_cannot_be_otherwise(tmp_path: Path) -> None:
    file = tmp_path / "trial.yaml"
    text = FILE.replace("{FACTORS}", "[tilt, roll]").replace("EXPECTS", "")
    file.write_text(text.replace("drive_on", "climb"), "utf-8")
    tilt, roll = read_campaign(file, check=False).cells[0].around

    assert (tilt.written(tilt.low), tilt.written(tilt.high)) == ("45 deg", "90 deg")
    assert roll.written(roll.high) == "45 deg"


def test_a_defect_is_run_at_the_end_of_its_range_but_where_that_is_none_of_it(
    tmp_path: Path,
) -> None:
    factors = "{'gamma_2_sticks:after': 0 s..9 s, 'messages_lost:share': usual}"
    sticks, lost = plan_of(tmp_path, factors).cells[0].around

    assert (sticks.nominal, sticks.added) == (9.0, True)
    assert (lost.nominal, lost.added) == (0.0, False)


def test_the_check_finds_what_a_campaign_would_be_refused_for(tmp_path: Path) -> None:
    with pytest.raises(Exception, match="frction"):
        plan_of(tmp_path, "[frction]")

    _, findings = check_campaign(tmp_path / "trial.yaml")

    assert [each.code for each in findings] == ["campaign.margins"]


def test_rolling_resistance_that_is_zero_in_the_files_has_a_default_range(tmp_path: Path) -> None:
    (tyre,) = plan_of(tmp_path, "[tyre.rolling_resistance]").cells[0].around

    assert (tyre.low, tyre.nominal, tyre.high) == (0.0, 0.0, 0.04)


def test_other_numbers_that_are_zero_in_the_files_need_a_range() -> None:
    loaded = load_mission(library.find_mission("drive_on"))
    order = Order("drive_on", numbers={"noise.current": "0 A"})
    (current,) = factors_around(order, loaded, Margins(factors={"noise.current": ("0 A", "1 A")}))

    assert (current.low, current.nominal, current.high) == (0.0, 0.0, 1.0)
    with pytest.raises(UsageError, match=r"noise\.current: give a range: its value .* is 0"):
        factors_around(order, loaded, Margins(factors={"noise.current": None}))


def test_friction_that_is_zero_in_the_files_is_no_factor() -> None:
    loaded = load_mission(library.find_mission("drive_on"))
    order = Order("drive_on", numbers={"friction.static": "0", "friction.kinetic": "0"})

    assert "friction" not in {each.name for each in factors_around(order, loaded, Margins())}
    with pytest.raises(UsageError, match="friction: it is 0 in the files, which cannot be scaled"):
        factors_around(order, loaded, Margins(factors={"friction": ("0", "1")}))


def test_the_campaign_file_of_the_page_about_margins_is_right(tmp_path: Path) -> None:
    (block,) = re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    file = tmp_path / "margins.yaml"
    file.write_text(block, "utf-8")

    assert not check_campaign(file)[1]


@pytest.mark.thorough
def test_margins_are_found_drawn_and_falsified(pirate: Any, tmp_path: Path) -> None:
    words = ["--factor", "friction=0.001..0.6", "--runs", "30", "--levels", "1", "--halvings", "1"]
    result = pirate(
        "margins", "drive_on", *words, "--share", "60%", "--format", "json", "-o", tmp_path / "a"
    )
    (cell,) = json.loads(result.stdout)["cells"]
    (friction,) = cell["margins"]

    assert result.exit_code == 0
    assert friction["holds_to"] == 0.6
    assert pirate("report", tmp_path / "a").exit_code == 0
    assert 'class="margins"' in (tmp_path / "a" / "index.html").read_text("utf-8")

    words = ["--factor", "tilt=-90deg..90deg", "--factor", "friction=0.001..0.6"]
    result = pirate("margins", "drive_on", "--falsify", *words, "--budget", "24", "-o",
                    tmp_path / "b")  # fmt: skip

    assert result.exit_code in (0, 1)
    assert "runs of drive_on" in result.stdout

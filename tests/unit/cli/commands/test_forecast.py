"""`pirate forecast`, and what `--forecast` says during a run and on the page of a recording."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.api import load, run
from pirate_sm.core.errors import UsageError
from pirate_sm.running.recording.forecast_file import (
    ForecastFile,
    counted,
    forecast_of,
    read_forecast,
)
from pirate_sm.running.recording.read.reader import read_recording

MISSION = """\
format: 1
mission: hold
robot: pirate_ii
pipe: straight_113
parameters: {pause: {type: duration, default: 1 s, min: 0 s, max: 60 s}}
start: clamp
phases:
  clamp: {do: [ClampFront], go: rest}
  rest: {wait: [{after: $pause, go: held}], within: {time: 100 s, go: held}}
ends:
  held: {succeed: It holds}
"""


@pytest.fixture
def mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "hold.yaml"
    file.write_text(MISSION, "utf-8")
    return file


@pytest.fixture
def recorded(mission: Path) -> Path:
    place = mission.with_name("hold.mcap")
    run(mission, record=place)
    return place


@pytest.fixture
def known(recorded: Path) -> Callable[..., Path]:
    """Writes a forecast from 40 runs like the recorded one, with changes."""

    def write(scale: float = 1.0, **changes: Any) -> Path:
        found = counted(read_recording(recorded))
        visits = [(phase, took_s * scale) for phase, took_s in found.visits]
        it = forecast_of(found.header, [visits] * 40)
        changes = {k: it.texts[:1] if k == "texts" else each for k, each in changes.items()}
        it = it.model_copy(update=changes)
        place = recorded.with_name("times.yaml")
        place.write_text(it.text(), "utf-8")
        assert read_forecast(place).runs[0][0][0] == visits[0][0]
        return place

    return write


def test_runs_in_the_simulator_make_a_forecast(pirate: Any, mission: Path) -> None:
    made = pirate("forecast", mission, "--rehearse", "3", "-o", "times.yaml")
    assert made.exit_code == 1  # too few
    assert "hold on pirate_ii in straight_113: 3 runs on sim that succeeded" in made.stdout
    assert "only 3 runs on sim, and 19 are needed: nothing is compared" in made.stdout
    again = read_forecast(Path("times.yaml"))
    assert [phase for phase, _ in again.runs[0]] == ["clamp", "rest"]
    assert ForecastFile.model_validate(again.model_dump()) == again


def test_recordings_in_a_folder_count_if_they_are_like_the_newest(
    pirate: Any, mission: Path, recorded: Path
) -> None:
    for number in range(2):
        recorded.with_name(f"more{number}.mcap").write_bytes(recorded.read_bytes())
    run(mission, backend="trace", record="trace.mcap")
    run(mission, numbers={"pipe.friction": 0.4}, record="numbers.mcap")
    Path("broken.mcap").write_bytes(recorded.read_bytes()[:100])
    made = pirate("forecast", ".")
    assert "3 runs on sim that succeeded" in made.stdout
    assert "1 of 5 runs are not counted: a trace, in which nothing moved" in made.stderr
    assert "not counted: with a defect or other numbers of the robot or the pipe" in made.stderr
    assert "broken.mcap" in made.stderr

    mission.write_text(MISSION.replace("It holds", "It has held"), "utf-8")
    run(mission, record="newest.mcap")
    made = pirate("forecast", ".")
    assert "1 run on sim that succeeded" in made.stdout
    assert "3 of 6 runs are not counted: of another text of the mission: hold.yaml" in made.stderr


def test_a_run_is_told_what_is_usual_and_warned_of_what_is_slow(
    pirate_run: Any, mission: Path, known: Callable[..., Path]
) -> None:
    told = pirate_run(mission, "--forecast", known(0.5), "--plain")
    assert told.exit_code == 0
    assert "clamp usually takes" in told.stdout
    assert "warning    rest is slower than in all 40 runs on sim" in told.stdout
    told = pirate_run(mission, "--forecast", known(), "--json")
    logs = [json.loads(line) for line in told.stdout.splitlines()]
    assert [each["level"] for each in logs if each["type"] == "log"].count("warning") == 0


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"forecast": "climb"}, "of the mission climb, not hold"),
        ({"robot": "newt"}, "of the robot newt, not pirate_ii"),
        ({"pipe": ""}, "of the pipe none, not straight_113"),
        ({"parameters": {"pause": "2 s"}}, "of runs with other values of parameters"),
        ({"texts": "the first"}, "of a run without one of the texts"),
    ],
)
def test_a_forecast_of_something_else_is_refused(
    pirate_run: Any,
    pirate: Any,
    mission: Path,
    recorded: Path,
    known: Callable[..., Path],
    changes: dict[str, Any],
    why: str,
) -> None:
    for told in (
        pirate_run(mission, "--forecast", known(**changes)),
        pirate("report", recorded, "--forecast", known(**changes)),
    ):
        assert told.exit_code == 2
        assert f"the forecast {recorded.with_name('times.yaml')} is {why}" in told.stderr


def test_a_forecast_of_another_text_is_refused_with_the_name_of_that(
    mission: Path, known: Callable[..., Path]
) -> None:
    place = known()
    mission.write_text(f"{MISSION}# edited\n", "utf-8")
    with pytest.raises(UsageError, match=r"of another text of the mission: hold\.yaml has the SHA"):
        run(load(mission), forecast=place)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mission: hold\n", "is not a forecast: `pirate forecast` makes one"),
        ("- 1\n", "is not a forecast"),
        ("forecast: hold\nformat: 1\n", "times.yaml:1:1: the key 'robot' is missing"),
    ],
)
def test_a_file_that_is_no_forecast_is_refused(
    pirate_run: Any, mission: Path, text: str, said: str
) -> None:
    Path("times.yaml").write_text(text, "utf-8")
    told = pirate_run(mission, "--forecast", "times.yaml")
    assert told.exit_code == 2
    assert said in told.stderr


def test_a_wrong_time_is_reported_with_its_place(
    pirate_run: Any, mission: Path, known: Callable[..., Path]
) -> None:
    place = known()
    text = place.read_text("utf-8").replace('["rest", 1', '["rest", -1', 1)
    place.write_text(text, "utf-8")
    told = pirate_run(mission, "--forecast", place)
    assert (told.exit_code, "expected at least 0.0" in told.stderr) == (2, True)


def test_signals_are_for_a_file_and_need_as_many_runs_as_times(
    pirate: Any, mission: Path, recorded: Path
) -> None:
    told = pirate("forecast", mission, "--rehearse", "2", "--signals")
    assert (told.exit_code, "name it with --output" in told.stderr) == (2, True)
    told = pirate("forecast", ".", "--signals", "-o", "times.yaml")
    assert "there are no bands of signals: 19 runs are needed" in told.stderr
    assert read_forecast(Path("times.yaml")).signals is None


@pytest.mark.thorough
@pytest.mark.parametrize("rehearsed", [True, False])
def test_bands_of_signals_are_behind_the_plots(
    pirate: Any, mission: Path, recorded: Path, *, rehearsed: bool
) -> None:
    for number in range(0 if rehearsed else 19):
        run(mission, seed=number, record=f"seed{number}.mcap")
    runs = [mission, "--rehearse", "20"] if rehearsed else ["."]
    made = pirate("forecast", *runs, "--signals", "-o", "times.yaml")
    assert (made.exit_code, " curves in 2 phases, of 20 runs" in made.stderr) == (0, True)
    assert read_forecast(Path("times.yaml")).text() == Path("times.yaml").read_text("utf-8")
    assert pirate("report", recorded, "--forecast", "times.yaml").exit_code == 0
    page = recorded.with_suffix(".html").read_text("utf-8")
    assert "shaded: 90 % of 20 runs on sim, each moment by itself" in page


def test_what_cannot_be_counted_is_refused(pirate: Any, mission: Path, recorded: Path) -> None:
    run(mission, backend="trace", record="trace.mcap")
    told = pirate("forecast", "trace.mcap")
    assert told.exit_code == 2
    assert "no run that can be counted: a trace, in which nothing moved (1)" in told.stderr
    assert "'hold.yaml' is neither a recording" in pirate("forecast", "hold.yaml").stderr
    assert "no run that can be counted" in pirate("forecast", ".", "--mission", "x").stderr
    told = pirate("forecast", recorded, "-o", recorded)
    assert (told.exit_code, "nothing is written over it" in told.stderr) == (2, True)
    two = pirate("forecast", mission, recorded, "--rehearse", "2")
    assert "--rehearse takes one mission or one campaign" in two.stderr


def test_one_cell_of_a_campaign_is_rehearsed(pirate: Any, mission: Path) -> None:
    Path("two.yaml").write_text(
        f"format: 1\ncampaign: two\nmissions: [{mission}]\nset: {{pause: [1 s, 2 s]}}\n", "utf-8"
    )
    told = pirate("forecast", "two.yaml", "--rehearse", "1")
    assert (told.exit_code, "name one cell with --cell: " in told.stderr) == (2, True)
    name = told.stderr.rpartition(", '")[2].strip().rstrip("'")
    made = pirate("forecast", "two.yaml", "--rehearse", "2", "--cell", name, "-o", "times.yaml")
    assert "2 runs on sim" in made.stdout
    assert read_forecast(Path("times.yaml")).parameters == {"pause": "2 s"}


def test_the_page_shows_what_was_expected(
    pirate: Any, recorded: Path, known: Callable[..., Path]
) -> None:
    assert pirate("report", recorded, "--forecast", known(0.5)).exit_code == 0
    page = recorded.with_suffix(".html").read_text("utf-8")
    assert "clamp usually takes" in page
    assert "rest is slower than in all 40 runs on sim" in page
    assert "shaded:" not in page  # it is a file without bands, as earlier versions wrote them
    two = pirate("report", ".", "--forecast", "times.yaml")
    assert (two.exit_code, "for the page of one recording" in two.stderr) == (2, True)

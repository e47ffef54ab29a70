"""Sensitivities: indices of known functions, through the files, runs and store of campaigns."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from math import isclose, isnan, nan, pi, sin
from pathlib import Path
from random import Random

import pytest

from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import find_robot
from pirate_sm.core.loading import load_robot, simulated_profile
from pirate_sm.lab.campaign import sensitivity
from pirate_sm.lab.campaign.campaign_file import check_campaign, read_campaign
from pirate_sm.lab.campaign.campaign_model import StoppingRule
from pirate_sm.lab.campaign.chunk import Chunk, RunRow, Sent, run_chunk
from pirate_sm.lab.campaign.conductor import Conductor, chunk_of, stored
from pirate_sm.lab.campaign.page import page_of
from pirate_sm.lab.campaign.plan import CampaignPlan, code_version, mark_of
from pirate_sm.lab.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.lab.campaign.sensitivity import Decided, Design, RunOutcome, decided
from pirate_sm.lab.campaign.sensitivity_model import Factor
from pirate_sm.lab.campaign.store import Store
from pirate_sm.lab.campaign.tally import Tally

from .rows import Hasty, row

FILE = """\
format: 1
campaign: trial
missions: [{mission: drive_on, pipe: straight_113}]
sensitivity:
  method: METHOD
  points: POINTS
  numbers:
    motors: {wheel: {no_load_speed: 2 rad/s..4 rad/s, hold_torque: 0.1 Nm..0.4 Nm}}
    friction: {kinetic: 0.3..0.5}
"""
SPEED, HOLD = "motors.wheel.no_load_speed", "motors.wheel.hold_torque"


def of_file(folder: Path, method: str = "sobol", points: int = 64, text: str = FILE) -> Path:
    file = folder / "trial.yaml"
    file.write_text(text.replace("METHOD", method).replace("POINTS", str(points)), "utf-8")
    return file


def by_name(found: Decided) -> dict[str, Mapping[str, float]]:
    return {each.name: each.indices for each in found.numbers}


NAMES = (Factor("a", "", 0.0, 1.0), Factor("b", "", 0.0, 1.0))


def what_decides(
    design: Design, run: Callable[[int, float, float], tuple[float, float]]
) -> tuple[Decided, ...]:
    """Return what decides runs whose success and time are functions of their number and a, b."""
    numbers = [tuple(design.drawn(each).values()) for each in range(design.runs)]
    runs = [(RunOutcome(*run(n, *each), float("nan")), each) for n, each in enumerate(numbers)]
    return decided(design, runs, 0.95)


def test_what_a_number_does_with_the_noise_alone_is_no_effect_of_it_alone() -> None:
    design = Design("sobol", 2048, NAMES)

    def run(number: int, a: float, b: float) -> tuple[float, float]:
        noise = Random(design.seed(number)).choice((-1.0, 1.0))
        return 1.0, a * noise + b

    _, time, _ = what_decides(design, run)

    # a: variance 0, in all E[a²] = 1/3; b: 1/12.
    found, variance = by_name(time), 1 / 3 + 1 / 12
    assert found["a"]["first"] == pytest.approx(0.0, abs=0.1)
    assert found["a"]["total"] == pytest.approx(1 / 12 / variance, abs=0.05)  # with the noise
    assert found["b"]["first"] == pytest.approx(1 / 12 / variance, abs=0.1)


@pytest.mark.parametrize(("share", "known"), [(0.004, True), (0.2, False)])
def test_of_points_chosen_by_their_success_there_are_no_indices(share: float, known: bool) -> None:
    time = what_decides(Design("sobol", 256, NAMES), lambda _, a, b: (a > share, 10 + a + b))[1]

    assert bool(time.numbers) is known
    assert (time.counted >= 0.95) is known
    assert ("fewer than 95%" in time.summary) is not known


def test_a_refused_run_is_no_run_that_failed() -> None:
    design = Design("sobol", 128, NAMES)

    success, time, _ = what_decides(
        design, lambda n, a, b: (nan, 0.0) if n == 7 else (b > 0.02, 10 + a + b)
    )

    assert (success.points, success.left_out) == (127, 1)
    assert success.numbers[0].name == "b"
    assert "127 of 128 points count (1 left out: a run was refused or met" in success.summary
    assert 0 < time.points < 127
    nothing = what_decides(design, lambda n, _a, _b: (nan, 0.0))
    assert [each.numbers for each in nothing] == [()] * 3
    runs = [(RunOutcome(1.0, 10.0, nan), (nan, nan))] * design.runs  # refused before it drew
    assert [each.points for each in decided(design, runs, 0.95)] == [0] * 3


def test_refused_runs_and_bugs_are_told_apart_from_failed_ones(tmp_path: Path) -> None:
    (cell,) = read_campaign(of_file(tmp_path, "morris", 2)).cells
    tally = Tally(cell, 0.95, StoppingRule())

    tally.add(
        row(cell.key, run, "failed")._replace(outcome=outcome)
        for run, outcome in enumerate(("refused", "bug", "failed"))
    )

    assert [isnan(outcome.success) for outcome, _ in tally.outcomes] == [True, True, False]


def run_all(design: Design, function: Callable[..., float]) -> Decided:
    """Return what decides the time of runs, which is a function of their numbers."""
    numbers = [tuple(design.drawn(run).values()) for run in range(design.runs)]
    runs = [(RunOutcome(True, function(*each), float("nan")), each) for each in numbers]
    success, time, slip = decided(design, runs, 0.95)
    assert success.numbers == slip.numbers == ()  # all alike, and unknown
    assert (success.points, slip.points) == (design.points, 0)
    return time


def test_the_indices_of_ishigami_are_found() -> None:
    """Ishigami and Homma 1990, with a = 7 and b = 0.1; the indices follow by integration."""
    design = Design("sobol", 1024, tuple(Factor(name, "", -pi, pi) for name in "xyz"))

    found = by_name(run_all(design, lambda x, y, z: sin(x) + 7 * sin(y) ** 2 + 0.1 * z**4 * sin(x)))

    b, c = 0.1 * pi**4 / 5, 0.1**2 * pi**8 / 18
    variance = 7**2 / 8 + b + c + 0.5
    known = {
        "x": (0.5 * (1 + b) ** 2 / variance, 1 - 7**2 / 8 / variance),
        "y": (7**2 / 8 / variance, 7**2 / 8 / variance),
        "z": (0.0, 8 * 0.1**2 * pi**8 / 225 / variance),
    }
    for name, (first, total) in known.items():
        assert found[name]["first"] == pytest.approx(first, abs=0.04)
        assert found[name]["total"] == pytest.approx(total, abs=0.04)
        assert abs(found[name]["total"] - total) <= 2 * found[name]["total_half_width"]


def test_the_effects_of_a_linear_function_are_its_slopes_over_the_ranges() -> None:
    design = Design("morris", 10, (Factor("a", "Nm", 1.0, 3.0), Factor("b", "", 0.0, 0.5)))

    time = run_all(design, lambda a, b: 4 * a - 2 * b)

    assert [each.name for each in time.numbers] == ["a", "b"]
    for name, slope in (("a", 8.0), ("b", -1.0)):
        indices = by_name(time)[name]
        assert (indices["mu"], indices["mu_star"]) == pytest.approx((slope, abs(slope)))
        assert indices["sigma"] == pytest.approx(0.0, abs=1e-9)
    assert [each.correlation > 0 for each in time.numbers] == [True, False]


# --- through the course of a campaign ------------------------------------------------------------


def as_its_numbers_say(chunk: Chunk, run: int) -> RunRow:
    """A slow robot takes longer; one that holds little fails."""
    order = chunk.order_of(run)
    drawn = {name: float(text.split()[0]) for name, text in order.numbers.items()}
    verdict = "failed" if drawn[HOLD] < 0.103 else "passed"
    slip_m = 0.1 * drawn["friction.kinetic"]
    found = row(chunk.cell, run, verdict, time_s=10.0 - 2.0 * drawn[SPEED])
    return found._replace(drawn=drawn, slip_m=slip_m)


def result(plan: CampaignPlan, folder: Path, crew: Hasty) -> CampaignResult:
    store = Store(folder)
    store.begin(mark_of(plan))
    conductor = Conductor(plan, store)
    try:
        conductor.conduct(crew)
    finally:
        store.close()
    kept = stored(folder)
    return result_of(kept.plan, kept.tallies, folder)


class KilledError(Exception):
    pass


@pytest.mark.parametrize(("method", "points"), [("sobol", 64), ("morris", 30)])
def test_what_decides_is_found_and_after_a_kill_the_same(
    tmp_path: Path, method: str, points: int
) -> None:
    plan = read_campaign(of_file(tmp_path, method, points))
    (cell,) = plan.cells
    assert cell.design is not None
    assert len(cell.seeds) == points * (5 if method == "sobol" else 4)

    whole = result(plan, tmp_path / "whole", Hasty(1, result=as_its_numbers_say))

    def dying(chunk: Chunk, run: int) -> RunRow:
        if run == 77:
            raise KilledError
        return as_its_numbers_say(chunk, run)

    with pytest.raises(KilledError):
        result(plan, tmp_path / "again", Hasty(2, room=1, result=dying))
    again = result(plan, tmp_path / "again", Hasty(3, result=as_its_numbers_say))

    (found,) = whole.cells
    assert found.decided == again.cells[0].decided
    success, time, slip = found.decided
    known = found.decided if method == "sobol" else found.decided[:1]  # too few paths passed whole
    assert [bool(each.numbers) for each in found.decided] == [
        each in known for each in found.decided
    ]
    names = [HOLD, SPEED, "friction.kinetic"][: len(known)]
    assert [each.numbers[0].name for each in known] == names
    assert [each.numbers[0].correlation < 0 for each in known] == [name == SPEED for name in names]
    assert (success.points, time.of) == (points, points)
    assert 0 < time.points == slip.points < points  # those whose runs all passed
    text = as_text(whole)
    assert f"time: {time.points} of {points} points count" in text
    assert f"        {SPEED}  " in text
    # The numbers of the first run that failed, which no seed gives.
    seed = cell.design.seed(found.causes[0].seeds[0])
    assert f"pirate run drive_on --seed {seed} " in found.causes[0].command
    assert f"--number '{HOLD}=0.1" in found.causes[0].command
    page = page_of(whole, "recordings")
    assert page.count("What decides") == 2 * len(known)  # title and label of each
    assert page.count("How long a bar is says") == 1
    assert "Success against wheel hold torque" in page
    assert ">wheel no load speed<" in page


def test_the_runs_of_a_point_have_one_seed_and_the_robot_that_was_drawn(tmp_path: Path) -> None:
    plan = read_campaign(of_file(tmp_path, "morris", 2))
    (cell,) = plan.cells
    assert cell.design is not None
    chunk = chunk_of(cell, range(3, 5))
    assert [chunk.order_of(run).seed for run in range(3, 5)] == [0, 1]

    rows = run_chunk(chunk, Sent(cell.mission, plan.missions[cell.mission]), code_version())

    for each in rows:
        drawn = cell.design.drawn(each.seed)
        assert each.drawn == pytest.approx(drawn, rel=1e-5)
        assert each.outcome == "succeeded"
        assert 0.0 <= each.slip_m < 0.02
    assert not isclose(rows[0].time_s, rows[1].time_s)


# --- files ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("POINTS", "48", "`points` of Sobol's sequence are a power of two, such as 64 or 256"),
        ("missions", "seeds: 0..9\nmissions", "`points` say how often it runs: leave seeds out"),
        ("missions", "stop: {violated: true}\nmissions", "indices need all runs: delete it"),
        ("2 rad/s..4 rad/s", "2 rad/s", "expected a range such as 0.5 Nm..2 Nm, got '2 rad/s'"),
        ("2 rad/s..4 rad/s", "4 rad/s..2 rad/s", "there is nothing to draw in '4 rad/s..2 rad/s'"),
        (
            "0.3..0.5",
            "0.3..4",
            "with 4 no run can begin: friction.static = 5.6: expected at most 5",
        ),
        ("2 rad/s..4 rad/s", "0 rad/s..2 rad/s", "'0 rad/s..2 rad/s' goes beyond what this can be"),
        (
            "2 rad/s..",
            "2 Nm..",
            "expected an angular speed such as '3 rad/s', got '2 Nm', a torque",
        ),
        ("wheel:", "wheels:", "there is no kind of motor 'wheels'"),
        ("hold_torque: 0.1 Nm", "stiffness: 1 Nm/rad", "expected"),
        ("0.3..0.5", "0.3..0.5, static: 0.4..0.7", "draw one coefficient of friction"),
    ],
)
def test_faults_are_found_before_anything_runs(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    file = of_file(tmp_path, text=FILE.replace(old, new, 1))

    _, findings = check_campaign(file)

    assert message in findings[0].message
    with pytest.raises(LoadError):
        read_campaign(file)


def test_one_number_alone_is_compared_with_nothing(tmp_path: Path) -> None:
    text = FILE.replace(
        "    motors: {wheel: {no_load_speed: 2 rad/s..4 rad/s, hold_torque: 0.1 Nm..0.4 Nm}}\n", ""
    )

    _, findings = check_campaign(of_file(tmp_path, text=text))

    assert "name two numbers at least" in findings[0].message


def test_its_points_are_not_given_on_the_command_line(tmp_path: Path) -> None:
    with pytest.raises(LoadError, match="`points` say how often it runs"):
        read_campaign(of_file(tmp_path), range(10))


def test_a_number_alone_takes_the_other_along_and_leaves_the_rest() -> None:
    profile = load_robot(find_robot("pirate_ii")).profile
    numbers = {SPEED: "3 rad/s", "friction.kinetic": "0.25", "noise.angle": "0.1 deg"}

    found = simulated_profile(profile, None, numbers=numbers)

    assert found.motors["wheel"].no_load_speed == 3.0
    assert found.motors["bend"] == profile.motors["bend"]
    friction, own = found.simulation.friction, profile.simulation.friction
    assert friction.static / friction.kinetic == pytest.approx(own.static / own.kinetic)
    assert friction.kinetic == 0.25
    assert found.simulation.noise.angle == pytest.approx(pi / 1800)
    assert found.simulation.noise.current == profile.simulation.noise.current
    with pytest.raises(UsageError, match="a robot has no number 'speed': expected motors"):
        simulated_profile(profile, None, numbers={"speed": "1"})
    with pytest.raises(LoadError, match="there is no kind of motor 'bent'"):
        simulated_profile(profile, None, numbers={"motors.bent.stiffness": "1 Nm/rad"})


def test_a_report_without_the_library_has_the_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = read_campaign(of_file(tmp_path, "morris", 4))
    result(plan, tmp_path / "whole", Hasty(1, result=as_its_numbers_say))
    for name in [name for name in sys.modules if name.partition(".")[0] == "SALib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "SALib", None)

    kept = stored(tmp_path / "whole")
    found = result_of(kept.plan, kept.tallies, tmp_path / "whole")

    assert "of 16" in as_text(found)
    assert "no indices: a sensitivity needs SALib, which is not installed" in as_text(found)
    assert "No indices: a sensitivity needs SALib" in page_of(found, "recordings")


def test_the_key_of_a_cell_has_its_points_and_no_versions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = of_file(tmp_path, "morris", 4)
    (before,) = read_campaign(file).cells
    monkeypatch.setattr("importlib.metadata.version", lambda package: "99")
    assert read_campaign(file).cells[0].key == before.key
    assert before.design is not None
    others = 2 * sensitivity._points(before.design)

    monkeypatch.setattr(sensitivity, "_points", lambda design: others)

    assert read_campaign(file).cells[0].key != before.key


def test_the_shipped_example_can_begin() -> None:
    file = Path(__file__).parents[4] / "campaigns" / "sensitivity.yaml"

    documents, findings = check_campaign(file)

    assert documents
    assert not findings

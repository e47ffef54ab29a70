"""Campaign files: the cells they make, and all that is wrong with them at once, with places."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.lab.campaign.campaign_file import check_campaign, read_campaign
from pirate_sm.lab.campaign.campaign_model import StoppingRule
from pirate_sm.lab.campaign.plan import CampaignPlan, command_of, mark_of, plan_of
from pirate_sm.lab.campaign.tally import Tally


def planned(folder: Path, text: str) -> CampaignPlan:
    file = folder / "trial.yaml"
    form = "" if "format: " in text else "format: 1\n"
    file.write_text(f"{text}{form}", "utf-8")
    return read_campaign(file, check=False)


def problems_of(folder: Path, text: str) -> list[str]:
    with pytest.raises(LoadError) as caught:
        planned(folder, text)
    return [
        f"{each.place.line}:{each.place.column} {each.message}" for each in caught.value.problems
    ]


CAMPAIGN = """\
campaign: trial
missions:
  - mitre_bend
  - mission: drive_on
    name: straight on
    set: {way: {from: 100 mm, to: 0.3 m, by: 100 mm}}
defects: [none, [messages_lost, gamma_2_stiff]]
jitter: {start: 20 mm, friction: 20 %}
seeds: 0..9
expect: {success: ">= 99 %"}
"""


def test_cells_are_all_combinations(tmp_path: Path) -> None:
    plan = planned(tmp_path, CAMPAIGN)

    assert [cell.name for cell in plan.cells] == [
        "mitre_bend: no defect",
        "mitre_bend: messages_lost + gamma_2_stiff",
        "straight on: way 0.1 m, no defect",
        "straight on: way 0.1 m, messages_lost + gamma_2_stiff",
        "straight on: way 0.2 m, no defect",
        "straight on: way 0.2 m, messages_lost + gamma_2_stiff",
        "straight on: way 0.3 m, no defect",
        "straight on: way 0.3 m, messages_lost + gamma_2_stiff",
    ]
    assert len({cell.key for cell in plan.cells}) == 8
    assert {cell.expect.success for cell in plan.cells} == {0.99}
    assert {(cell.order.start_jitter_m, cell.order.friction_jitter) for cell in plan.cells} == {
        (0.02, 0.2)
    }
    assert plan.cells[0].seeds == range(10)


def test_a_twin_names_a_robot_of_its_sample_or_has_each_seed_draw_one(tmp_path: Path) -> None:
    (tmp_path / "twin.yaml").write_text(
        "format: 1\nrobot: pirate_ii\n"
        "sample: {numbers: [bend no_load_speed], robots: [[0.8], [0.9]]}\n"
    )
    text = "campaign: trial\nmissions: [mitre_bend]\nseeds: 5\ntwin: twin.yaml"

    plans = [planned(tmp_path, f"{text}{which}\n") for which in ("", "#1", "#seed")]

    orders = [plan.cells[0].order for plan in plans]
    assert [Path(order.twin or "").name for order in orders] == [
        "twin.yaml", "twin.yaml#1", "twin.yaml#seed"
    ]  # fmt: skip
    assert len({plan.cells[0].key for plan in plans}) == 3
    (tmp_path / "twin.yaml").rename(tmp_path / "moved.yaml")
    (cell,) = plan_of(mark_of(plans[2])).cells  # as a report of the results reads it
    (counted,) = Tally(cell, 0.95, StoppingRule()).factors
    assert (counted.factor.low, counted.factor.high) == (0.8, 0.9)
    (tmp_path / "twin.yaml").write_text("format: 1\nrobot: pirate_ii\n")
    (problem,) = problems_of(tmp_path, f"{text}#seed\n")
    assert "it has one robot and no `sample`" in problem


def test_belief_is_tried_with_timed_defects_in_campaigns(tmp_path: Path) -> None:
    drawn = "{defect: gamma_2_stiff, friction: 0.3 Nm, after: 2 s..20 s}"
    text = CAMPAIGN.replace("gamma_2_stiff", f"{drawn}, {{defect: wheel_1_dead}}")
    order = planned(tmp_path, text).cells[1].order

    expected = "gamma_2_stiff:friction=0.3Nm,after=2s..20s"
    assert order.defects == ("messages_lost", expected, "wheel_1_dead")
    assert f"--defect {expected} --defect wheel_1_dead" in command_of(order, 7)
    assert problems_of(
        tmp_path,
        "campaign: trial\nmissions: [mitre_bend]\nseeds: 5\n"
        "defects: [none, {defect: gamma_2_stiff, friction: 2 mm}, 'wheel_1_dead:lasting=1s']\n",
    ) == [
        "4:17 gamma_2_stiff: friction: expected a torque such as '0.8 Nm', got '2mm', a length",
        "4:58 the defect wheel_1_dead takes no number 'lasting': expected one of friction, after",
    ]


@pytest.mark.thorough
def test_belief_is_tried_with_every_defect_alone_and_in_pairs_at_any_time(tmp_path: Path) -> None:
    text = "campaign: trial\nmissions: [mitre_bend]\nseeds: 5\ndefects: [{}]\n"
    late = "each:after=0s..20s"
    alone = planned(tmp_path, text.format("each")).cells
    timed = planned(tmp_path, text.format(f"none, {late}")).cells
    pairs = planned(tmp_path, text.format(f"[{late}, {late}]")).cells
    with_one = planned(tmp_path, text.format("[each, messages_lost]")).cells

    count = len(alone)
    assert [cell.order.defects for cell in timed] == [
        (),
        *((f"{cell.order.defects[0]}:after=0s..20s",) for cell in alone),
    ]
    assert len({frozenset(cell.order.defects) for cell in pairs}) == len(pairs)
    assert len(pairs) == count * (count - 1) / 2
    assert len(with_one) == count - 1
    assert problems_of(tmp_path, text.format("each:friction=1Nm")) == [
        "4:11 the defect gamma_2_drops takes no number 'friction': expected one of "
        "shows, after, every, lasting"
    ]


def test_a_cell_has_the_command_that_repeats_a_run(tmp_path: Path) -> None:
    cell = planned(tmp_path, CAMPAIGN).cells[3]

    assert command_of(cell.order, 7) == (
        "pirate run drive_on --seed 7 --speed max --set 'way=0.1 m' "
        "--defect messages_lost --defect gamma_2_stiff --jitter start=20mm --jitter friction=20%"
    )


def test_a_plan_survives_being_written_down(tmp_path: Path) -> None:
    line = "line: {loss_in: 10 %, delay: 3 ms}\nstop: {half_width: 1 %}\n"
    text = f"{CAMPAIGN}backend: [sim, bay]\n{line}"
    plan = planned(tmp_path, text)
    read = plan_of(mark_of(plan))

    assert [command_of(each.order, 1) for each in read.cells] == [
        command_of(each.order, 1) for each in plan.cells
    ]
    assert mark_of(read) == mark_of(plan)
    assert "--line loss_in=10% --line delay=3ms" in command_of(read.cells[-1].order, 1)


def test_keys_tell_results_apart_that_may_differ(tmp_path: Path) -> None:
    one, other = planned(tmp_path, CAMPAIGN), planned(tmp_path, CAMPAIGN.replace("20 %", "10 %"))
    same = planned(tmp_path, CAMPAIGN.replace("0..9", "0..99").replace("99 %", "90 %"))

    assert not {cell.key for cell in one.cells} & {cell.key for cell in other.cells}
    assert [cell.key for cell in one.cells] == [cell.key for cell in same.cells]


def test_every_fault_is_reported_at_its_place(tmp_path: Path) -> None:
    assert problems_of(
        tmp_path,
        "campaign: trial\n"
        "missions: [mitre_bent, {mission: mitre_bend, pip: x}]\n"
        "seeds: 9..0\n"
        "expect: {success: 101 %}\n"
        "stop: {half_width: 0 %}\n"
        "colour: red\n",
    ) == [
        "2:12 there is no mission 'mitre_bent'; did you mean 'mitre_bend'?",
        "2:46 unknown key 'pip'",
        "3:8 there are no seeds in '9..0'",
        "4:19 expected a share of at most 100 %, got '101 %'",
        "5:20 expected more than 0 %, got '0 %'",
        "6:1 unknown key 'colour'",
    ]
    assert problems_of(
        tmp_path,
        "campaign: trial\n"
        "missions: [mitre_bent, mitre_bend]\n"
        "defects: [none, gamma_2_stif]\n"
        "line: {loss_in: 1 %}\n"
        "seeds: 5\n",
    ) == [
        "2:12 there is no mission 'mitre_bent'; did you mean 'mitre_bend'?",
        "3:17 there is no defect 'gamma_2_stif'",
        "4:7 only the backend bay has a line",
    ]


def test_the_faults_of_all_names_are_reported_at_once(tmp_path: Path) -> None:
    text = (
        "campaign: trial\n"
        "missions:\n"
        "- {mission: mitre_bent, pipe: mitre_9}\n"
        "- mission: mitre_bend\n"
        "  set:\n"
        "    give_up: [30 s, 5 mm]\n"
        "    give_upp: 3 s\n"
        "  defects: [none, [gamma_2_drops, gamma_2_stif]]\n"
        "  end: {states: [[Foo], [Free, Free, Unclampd, Unaligned, Off]]}\n"
        "- {mission: drive_on, detector: [sim, odometri], pipe: [mitre_90, nope], robot: pirate}\n"
        "- {mission: mitre_bend, twin: nowhere.yaml, detector: 'vision:nowhere'}\n"
        "seeds: 5\n"
    )
    expected = [
        "3:13 there is no mission 'mitre_bent'",
        "3:31 there is no pipe 'mitre_9'",
        "6:21 parameter 'give_up': expected a duration",
        "7:5 the mission mitre_bend has no parameter 'give_upp'",
        "8:35 there is no defect 'gamma_2_stif'",
        "9:18 1 of the robot's 5 states is given",
        "9:38 BendingState has no state 'Unclampd'",
        "10:39 there is no detector 'odometri'",
        "10:67 there is no pipe 'nope'",
        "10:81 there is no robot 'pirate'",
        "11:31 there is no file 'nowhere.yaml'",
        "11:55 there is no camera 'nowhere'",
    ]

    found = problems_of(tmp_path, text)
    assert [each[: len(want)] for each, want in zip(found, expected, strict=True)] == expected
    with_faulty_form = problems_of(tmp_path, f"{text}colour: red\nfidelity: quick\n")
    assert with_faulty_form[:-2] == found
    assert [each[:4] for each in with_faulty_form[-2:]] == ["13:1", "14:1"]


def test_a_fault_of_a_mission_is_reported_at_its_own_place(tmp_path: Path) -> None:
    own = "format: 1\nmission: own\nrobot: pirate_ii\nstart: a\nphases: {a: {go: b}}\n"
    (tmp_path / "own.yaml").write_text(f"{own}ends: {{e: {{succeed: Done}}}}\n", "utf-8")
    (tmp_path / "broken.yaml").write_text("format: 1\npipe: broken\ndiameter: 2\n", "utf-8")
    with pytest.raises(LoadError) as caught:
        planned(tmp_path, "campaign: t\nseeds: 1\nmissions: [own]\npipe: broken\n")

    places = [(Path(str(each.place)).name, each.message) for each in caught.value.problems]
    assert ("own.yaml:5:18", "there is no phase or end 'b'") in places
    assert ("broken.yaml:3:11", "expected a length such as '120 mm', got '2' without a unit") in (
        places
    )


def test_a_parameter_without_a_default_needs_a_value(tmp_path: Path) -> None:
    text = (
        "format: 1\nmission: own\nrobot: pirate_ii\npipe: mitre_90\n"
        "parameters: {patience: {type: duration}}\nstart: a\n"
        "phases: {a: {wait: [{after: $patience, go: e}]}}\nends: {e: {succeed: Done}}\n"
    )
    (tmp_path / "own.yaml").write_text(text, "utf-8")
    campaign = "campaign: t\nseeds: 1\nmissions: [{mission: own}]\n"

    assert problems_of(tmp_path, campaign) == ["3:22 parameter 'patience' of own has no default"]
    plan = planned(tmp_path, f"{campaign}set: {{patience: 3 s}}\n")
    assert plan.cells[0].order.settings == {"patience": "3 s"}


def test_what_cannot_be_run_is_reported_at_the_choice_that_prevents_it(tmp_path: Path) -> None:
    text = "campaign: t\nseeds: 1\nmissions: [mitre_bend]\nbackend: physics\nfidelity: fast\n"

    assert problems_of(tmp_path, text)[0].startswith("5:11 the backend physics cannot be made fast")


def test_a_campaign_needs_its_format(tmp_path: Path) -> None:
    file = tmp_path / "trial.yaml"
    file.write_text("campaign: t\nmissions: [mitre_bend]\nseeds: 1\n", "utf-8")
    with pytest.raises(LoadError, match=r"the key 'format' is missing\n.*\n.*\n.*`format: 1`"):
        read_campaign(file)


def test_too_many_cells_are_refused(tmp_path: Path) -> None:
    many = "{from: 10 s, to: 509 s, by: 1 s}"
    missions = f"[{{mission: turn, set: {{a: {many}, b: {many}}}}}]"
    (tmp_path / "turn.yaml").write_text(
        "format: 1\nmission: turn\nrobot: pirate_ii\npipe: mitre_90\n"
        "parameters: {a: {type: duration, default: 1 s}, b: {type: duration, default: 1 s}}\n"
        "start: p\nphases: {p: {wait: [{after: $a, go: q}]}, q: {wait: [{after: $b, go: e}]}}\n"
        "ends: {e: {succeed: Done}}\n",
        "utf-8",
    )
    found = problems_of(tmp_path, f"campaign: t\nseeds: 1\nmissions: {missions}\n")

    assert found == ["3:12 this mission has more than 10,000 cells: leave out some choices"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("format: 2", "4:9 this program reads format 1, and this is format 2"),
        ("jitter: {friction: 20 mm}", "4:20 expected a ratio such as '60 %'"),
        (
            "jitter: {diameter: 200 mm}",
            "4:9 jitter of the diameter: expected from 0 to below 12 mm",
        ),
        ("jitter: {start: 99 m}", "4:9 jitter of the start: expected from 0 to below the length"),
        ("end: {beyond: 99 m}", "4:6 beyond: 99 m is not in the pipe, which is 2"),
        (
            "end: {beyond: 1.2 m, before: 1 m}",
            "4:15 the clamped robot, 0.282 m long, is not between 1.2 m and 1 m",
        ),
        ("end: {beyond: 1.8 m}", "4:15 the clamped robot, 0.282 m long, is not between"),
        ("expect: {success: many}", "4:19 expected a least share such as '>= 99 %'"),
        (
            "set: {give_up: {from: 1 s, to: 20 min, by: 1 min}}",
            "4:23 parameter 'give_up': 1.0 s is",
        ),
        ("set: {give_up: {from: 1 s, to: 1e9 s, by: 1 ms}}", "more than 1,000 values"),
        ("seeds: 0", "4:8 there are no seeds in '0'"),
        ("seeds: []", "4:8 expected seeds such as 0..999"),
        ("seeds: [1, 1]", "4:8 a seed is listed twice"),
        ("seeds: many", "4:8 expected seeds such as 0..999"),
        ("set: {give_up: {from: 2 s, to: 1 s, by: 1 s}}", "the range is empty"),
        ("set: {give_up: {from: 1 s, to: 2 s, by: 0 s}}", "`by` must be more than zero"),
        ("set: {give_up: {from: 1 s, to: 2 m, by: 1 s}}", "need units of one kind"),
        ("set: {give_up: []}", "4:16 this is empty"),
        ("set: {giveup: 30 s}", "giveup"),
        ("pipe: mitre_9O", "4:7 there is no pipe 'mitre_9O'"),
        ("detector: oracle", "there is no detector 'oracle'"),
        ("backend: real", "4:10 "),
        ("fidelity: fast\nbackend: physics", "cannot be made fast"),
        ("missions: mitre_bend", "'missions'"),
        ("expect: {success: 0.9}", "4:19 expected a least share such as '>= 99 %'"),
    ],
)
def test_a_fault_is_reported(tmp_path: Path, line: str, message: str) -> None:
    seeds = "" if "seeds" in line else "seeds: 1"
    text = f"campaign: trial\nmissions: [mitre_bend]\n{seeds}\n{line}\n"
    assert message in "\n".join(problems_of(tmp_path, text))


def test_two_cells_of_one_name_are_told_apart_by_names(tmp_path: Path) -> None:
    text = (
        "campaign: trial\nseeds: 1\nmissions: [mitre_bend, {mission: mitre_bend, fidelity: fast}]\n"
    )
    assert "there are two cells 'mitre_bend'" in problems_of(tmp_path, text)[0]
    named = text.replace("fidelity", "name: fast, fidelity")
    assert [cell.name for cell in planned(tmp_path, named).cells] == ["mitre_bend", "fast"]


def test_a_campaign_needs_seeds(tmp_path: Path) -> None:
    text = "campaign: trial\nmissions: [mitre_bend]\n"
    assert "nothing says how often it runs" in problems_of(tmp_path, text)[0]


def test_files_are_searched_beside_the_campaign(tmp_path: Path) -> None:
    (tmp_path / "tube.yaml").write_text(
        "format: 1\npipe: tube\ndiameter: 120 mm\nsegments: [{straight: 2 m}]\n"
        "start: {at: 700 mm}\n"
    )
    plan = planned(tmp_path, "campaign: t\nmissions: [{mission: climb, pipe: tube}]\nseeds: 1\n")

    assert plan.cells[0].order.pipe == str(tmp_path / "tube.yaml")


def test_a_mission_is_a_campaign_with_one_cell() -> None:
    file = Path(__file__).parents[4] / "sequences" / "mitre_bend.yaml"
    plan = read_campaign(file, range(5), check=False)

    assert [(cell.name, cell.seeds) for cell in plan.cells] == [("mitre_bend", range(5))]
    with pytest.raises(UsageError, match="say how often it runs with --seeds"):
        read_campaign(file, check=False)


def test_a_word_at_the_end_needs_a_bend(tmp_path: Path) -> None:
    text = "campaign: trial\nmissions: [NAME]\nseeds: 5\nend: {at_word: true}\n"

    assert planned(tmp_path, text.replace("NAME", "mitre_bend"))
    (said,) = problems_of(tmp_path, text.replace("NAME", "drive_on"))
    assert said.startswith("4:16 at_word: nothing says a word here")


@pytest.mark.parametrize(("seeds", "warned"), [(50, True), (200, False)])
def test_seeds_are_enough_for_the_half_width(tmp_path: Path, seeds: int, warned: bool) -> None:
    file = tmp_path / "trial.yaml"
    text = "format: 1\ncampaign: trial\nmissions: [mitre_bend]\nstop: {half_width: 2 %}\n"
    file.write_text(f"{text}seeds: {seeds}\n", "utf-8")

    found = [
        f"{each.place.line}:{each.place.column} {each.message}" for each in check_campaign(file)[1]
    ]
    said = "4:20 with 50 seeds an interval is 3.57% to each side at best"
    assert found == [said] * warned

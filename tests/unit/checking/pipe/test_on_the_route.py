"""What a mission calls must pass the next bend of its route, says `travel` of the robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.mission.check_mission import check_mission

from ..robots import PIRATE, changed

HELD = "starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}"
PASSAGE = "{joints: [mitre], turns: true, towards: [0 deg], calls: [take_bend]}"
BENDS = (
    "DriveForward, Brake, RelaxFront, BendInto, ClampFront, RelaxRear, BendBack, ClampRear,"
    " DriveForward, Brake"
)


def passages(folder: Path, passage: str, segment: str = "mitre: 90 deg") -> list[str]:
    """What is said of a call of `take_bend` that is for other joints than this one."""
    changed(PIRATE, folder, "profile.yaml", (PASSAGE, passage))
    segments = f"[{{straight: 1 m}}, {{{segment}}}, {{straight: 1 m}}]"
    pipe = f"{{section: round, diameter: 120 mm, segments: {segments},"
    for name, do, more in (
        ("take_bend", BENDS, ""),
        ("m", "{call: take_bend}", f"pipe: {pipe} start: {{at: 700 mm}}}}\n"),
    ):
        (folder / f"{name}.yaml").write_text(
            f"format: 1\nmission: {name}\nrobot: ./pirate_ii\n{more}{HELD}\nstart: a\nphases:\n"
            f"  a: {{do: [{do}], go: good}}\nends: {{good: {{succeed: Good}}}}\n",
            encoding="utf-8",
        )
    found = check_mission(folder / "m.yaml").findings
    return [f"{each.message} ({each.fix})" for each in found if each.code == "route.passage"]


@pytest.mark.parametrize(
    ("asked", "instead", "said"),
    [
        ("up_to: 90 deg", "up_to: 90 deg", ""),
        ("turns: false", "turns: true", "'take_bend' is for a mitre that is passed straight on"),
        ("up_to: 60 deg", "up_to: 90 deg", "'take_bend' is for a mitre of at most 60 deg"),
    ],
)
def test_a_passage_is_for_joints_that_turn_as_it_says(
    tmp_path: Path, asked: str, instead: str, said: str
) -> None:
    own = f"{{joints: [mitre], {asked}, calls: [take_bend]}}"
    other = f"{{joints: [mitre], {instead}, calls: [take_sharp]}}"
    found = passages(tmp_path, f"{own}\n    - {other}")

    turned = ", and the next bend of the route is a mitre that turns by 90 deg"
    assert found == [f"{said}{turned} (call 'take_sharp')"] * bool(said)


def test_a_joint_of_another_kind_is_named(tmp_path: Path) -> None:
    (said,) = passages(tmp_path, PASSAGE, "elbow: 90 deg, radius: 180 mm")

    assert said.startswith("'take_bend' is for a mitre, and the next bend of the route is an elbow")

"""Safety rules of a profile: compiled, or told what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot

NEWT = Path(__file__).resolve().parents[4] / "robots" / "newt"
OLD = "after: clamps > 0\n    never: clamps == 0\n    waived_by: allow_unclamp"


def load(folder: Path, rule: str) -> LoadedRobot:
    robot = folder / "newt"
    robot.mkdir()
    for file in ("chart.yaml", "profile.yaml"):
        text = (NEWT / file).read_text(encoding="utf-8").replace(OLD, rule)
        (robot / file).write_text(text, encoding="utf-8")
    (robot / "messages").symlink_to(NEWT / "messages")
    return load_robot(robot)


def test_a_rule_says_itself_in_one_line(tmp_path: Path) -> None:
    (rule,) = load(
        tmp_path, "after: clamps > 0\n    expect: clamps == 2\n    within_steps: 3"
    ).rules

    assert rule.text == "expect clamps == 2 within 3 steps after clamps > 0"
    assert rule.within == 3


def test_never_is_the_opposite_of_always(tmp_path: Path) -> None:
    (rule,) = load(tmp_path, "never: driven_wheels > 0 and confirmed_clamps == 0").rules
    words = ("Loose", "Resting", "Dark", None)

    assert rule.must.evaluate((0.0, 0.0, 2.0), words) is False
    assert rule.must.evaluate((1.0, 1.0, 2.0), words) is True


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        ("never: clmps == 0", "clmps"),
        ("never: Grip == Open", "Open"),
        ("never: clamps > 1 mm", "mm"),
        ("never: way > 1 mm", "way"),  # a rule sees what is commanded, not what is measured
        ("always: clamps", "condition"),
        ("never: command == Jump", "Jump"),
        ("expect: clamps == 2", "go together"),
        ("never: clamps == 0\n    always: clamps == 1", "exactly one"),
    ],
)
def test_what_is_wrong_with_a_rule_is_told_at_its_line(
    tmp_path: Path, rule: str, said: str
) -> None:
    with pytest.raises(LoadError, match=said) as raised:
        load(tmp_path, rule)

    lines = (NEWT / "profile.yaml").read_text(encoding="utf-8").splitlines()
    first = lines.index("rules:") + 1
    assert all(first < each.place.line <= first + 4 for each in raised.value.problems)


def test_two_rules_of_one_name_are_reported(tmp_path: Path) -> None:
    again = "never: clamps == 0\n  - rule: never_let_go\n    never: clamps == 1"

    with pytest.raises(LoadError, match="names another rule too"):
        load(tmp_path, again)

"""What `pirate doctor` shows: every sensor on one screen, and in words what plain lines hold."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from pirate_sm.cli.output.doctor_tables import link_lines, plain_text, sensors_now, verdict
from pirate_sm.robot.diagnosis.facts import (
    BoardFact,
    ChannelFact,
    DoctorFinding,
    Facts,
    LinkFact,
    TopicFact,
)

GOOD = TopicFact("state", "publishes", 125, "m/State", "m/State", "a" * 32, "a" * 32, 60.0)
ANGLE = ChannelFact("bend_angle", "gamma", -11.0, -12.0, -10.0, -0.0169, "-1.0 deg")
BOARDS = tuple(
    BoardFact(number, f"module_{number}", 50, 10.0, 10.4, 0.1, (ANGLE,) * 6)
    for number in range(22, 28)
)
LINK = LinkFact(2.1, 15000, 3, 0, 0, 1, 2, 0, 2, (17.0, 20.0, 18.0), (75.0, 80.0), 0.12)


@pytest.fixture
def facts() -> Facts:
    return Facts(
        "/dev/ttyACM0", "bot", 57600, 5.0, (GOOD,), BOARDS, (), LINK, ((1, "bay ready"),), ()
    )


def test_every_sensor_fits_on_one_screen_while_it_is_listened_to(facts: Facts) -> None:
    out = io.StringIO()
    Console(file=out, width=120).print(sensors_now(facts))

    lines = out.getvalue().splitlines()
    assert len(lines) <= 24
    assert out.getvalue().count("-1.0 deg") == 36
    assert "22 module_22, 10.0 per s" in lines[0]


def test_a_board_that_says_nothing_is_marked(facts: Facts) -> None:
    nothing = ChannelFact("bend_angle", "gamma", None, None, None, None, "")
    silent = replace(BOARDS[0], frames=0, channels=(nothing,))
    out = io.StringIO()

    Console(file=out, width=120).print(sensors_now(replace(facts, boards=(silent,))))

    assert "silent" in out.getvalue()


@pytest.mark.parametrize(
    ("topic", "shown"),
    [
        (GOOD, "aaaaaaaa = ours"),
        (replace(GOOD, md5="b" * 32), "bbbbbbbb, ours is aaaaaaaa"),
        (replace(GOOD, id=None, md5=""), "not offered"),
        (replace(GOOD, our_type="", our_md5=""), "aaaaaaaa, not used"),
    ],
)
def test_a_topics_md5_stands_beside_ours(facts: Facts, topic: TopicFact, shown: str) -> None:
    assert shown in plain_text(replace(facts, topics=(topic,)))


def test_the_link_is_told_in_words(facts: Facts) -> None:
    assert link_lines(facts) == [
        "answered 2.1 s after the port was opened; 57600 baud",
        "15000 bytes in 5.0 s, 3 of no frame, 0 messages unreadable, 0 strange",
        "2 requests for the time answered",
        "this computer stood still for 120 ms at most",
        "round trip of a question: median 18 ms, 17 to 20 ms (3)",
        "round trip of an array: median 78 ms, 75 to 80 ms (2); 2 repeated, 1 damaged echoes",
        "the firmware says: bay ready",
    ]


@pytest.mark.parametrize(
    ("levels", "shown"),
    [
        ([], "GO"),
        (["note"], "GO"),
        (["suspicious", "note"], "GO, with 1 thing to look at first"),
        (["suspicious", "suspicious"], "GO, with 2 things to look at first"),
        (["no-go", "suspicious"], "NO-GO: do not start a mission"),
    ],
)
def test_the_verdict_is_the_last_line(facts: Facts, levels: list, shown: str) -> None:
    findings = tuple(DoctorFinding(level, f"{level} it is") for level in levels)
    facts = replace(facts, findings=findings)

    assert verdict(facts) == shown
    assert plain_text(facts).splitlines()[-1 - len(levels) :] == [
        *(f"{level}: {level} it is" for level in levels),
        shown,
    ]

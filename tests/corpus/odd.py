"""Odd but correct missions, of which nothing must be said: every key, every kind of trigger.

Each is a few lines of its own around a common head, so that it can be read as somebody would
write it. A mission has the key that its name tells, used in a way that is unusual and right.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

PIRATE = "format: 1\nmission: m\nrobot: pirate_ii\n"
NEWT = "format: 1\nmission: m\nrobot: ../newt\n"
LEAVE = "start: a\nphases:\n  a: {do: [ClampFront, ClampRear, DriveForward], go: b}\n"
CRAWL = "start: a\nphases:\n  a: {do: [HoldNose, HoldTail, GoAhead], go: b}\n"
ENDS = "ends: {good: {succeed: Good}, bad: {fail: 'Bad: {cause}'}}\n"
LATE = "within: {time: 30 s, go: late}"
TAIL = "  late: {do: [Brake], go: bad}\n"
DOING = "start: a\nphases:\n  a:\n    do:\n      - {step}\n      - ClampRear\n    go: good\n"
HALT = "  c: {{do: [Brake, {{repeat: {{times: {times}, do: [ToggleLighting]}}}}], go: good}}\n"
REST = "  late: {do: [Rest], go: bad}\n"


class Odd(NamedTuple):
    """A mission, and files beside it."""

    name: str
    text: str
    beside: dict[str, str]


TRIGGERS = {
    "a way": "{when: odometry >= 300 mm, go: c}",
    "a way back": "{when: odometry < -5 mm or odometry > 300 mm, go: c}",
    "a way between": "{when: odometry > 100 mm and odometry < 400 mm, go: c}",
    "a way from here": "{when: change(odometry) >= 10 cm, go: c}",
    "a way from here to either side": "{when: abs(change(odometry)) > 10 cm, go: c}",
    "no way from here": "{when: abs(change(odometry)) < 5 mm, held: 5 s, go: c}",
    "a turn since then": "{when: change(gamma_1) > 10 deg or change(gamma_1) < -10 deg, go: c}",
    "a speed that has changed": "{when: change(speed) < -20 mm/s, held: 1 s, go: c}",
    "a speed that falls": "{when: abs(speed) < 10 mm/s, held: 2 s, go: c}",
    "an unknown signal": "{when: not known(speed), held: 500 ms, go: c}",
    "an angle": "{when: gamma_1 > 20 deg, held: 100 ms, go: c}",
    "two angles": "{when: gamma_1 > gamma_2 + 5 deg, go: c}",
    "the largest of angles": "{when: 'max(gamma_1, gamma_2, gamma_3) > 60 deg', go: c}",
    "a product": "{when: odometry * 2 > 500 mm, go: c}",
    "a quotient": "{when: odometry / 4 > 80 mm, go: c}",
    "a tilt": "{when: abs(pitch) > 30 deg, held: 1 s, go: c}",
    "a roll": "{when: roll > 10 deg or roll < -10 deg, held: 1 s, go: c}",
    "the pipe is left": "{when: segment == Out, go: c}",
    "a joint of the pipe": "{when: 'segment in (Joint, Out)', go: c}",
    "the word of the bend": "{when: detector == close, held: 200 ms, go: c}",
    "any word": "{when: 'detector in (close, in, past)', go: c}",
    "a known word": "{when: known(detector), held: 900 ms, go: c}",
    "the operator": "{operator: enough, go: c}",
    "the operator, named": "{operator: enough, name: by_hand, go: c}",
    "a time": "{after: 10 s, go: c}",
    "a time in minutes": "{after: 0.25 min, go: c}",
    "a wheel's torque": "{when: wheel_torque_1 > 100 mNm, held: 2 s, go: c}",
    "a width": "{when: diameter_front > 110 mm, held: 1 s, go: c}",
}
"""What ends a wait while the PIRATE drives forward in a pipe with a bend."""

STEPS = {
    "lights": "ToggleLighting",
    "an alias": "ToggleLight",
    "a command with a timeout": "{command: ToggleLighting, timeout: 3 s}",
    "a command with retries": "{command: ToggleLighting, retry: 3}",
    "what may be unneeded": "{command: ClampFront, unneeded: skip, if: known(gamma_1)}",
    "a condition": "{command: ToggleLighting, if: gamma_1 > 5 deg}",
    "a failure that is passed over": "{command: ToggleLighting, on_failure: continue}",
    "a failure that leads away": "{command: ToggleLighting, on_failure: bad}",
    "a log": "{log: 'Here after {cause}', level: warning}",
    "a log on a condition": "{log: Tilted, if: abs(pitch) > 20 deg}",
    "a repeat": "{repeat: {times: 3, do: [ToggleLighting]}}",
    "a repeat that may fail": "{repeat: {times: 2, do: [ToggleLighting]}, on_failure: continue}",
    "repeats in each other": "{repeat: {times: 2, do: "
    "[{repeat: {times: 2, do: [ToggleLighting]}}]}}",
    "a choice": "{choose: [{if: gamma_1 > 5 deg, do: [ToggleLighting]}]}",
    "a choice of three": "{choose: [{if: gamma_1 > 5 deg, do: [ToggleLighting]}, "
    "{if: gamma_1 < -5 deg, do: [{log: Left}]}], else: [{log: Straight}]}",
    "a choice with an else": "{choose: [{if: gamma_1 > 5 deg, do: [ToggleLighting]}, "
    "{if: gamma_1 <= 5 deg, do: [{log: Straight}]}], else: [{log: Unknown}]}",
    "a choice within a choice": "{choose: [{if: gamma_1 > 5 deg, do: [{choose: "
    "[{if: gamma_2 > 5 deg, do: [ToggleLighting]}], else: [{log: One}]}]}], else: [{log: None}]}",
    "a choice for all that can be": "{choose: [{if: known(gamma_1), do: [ToggleLighting]}, "
    "{if: not known(gamma_1), do: [{log: Blind}]}]}",
    "a condition on a speed": "{command: ToggleLighting, if: abs(speed) < 5 mm/s}",
    "a wait for a light touch": "{wait: [{when: abs(change(odometry)) > 5 mm, go: bad}, "
    "{after: 2 s}]}",
    "a question": "{ask: Go on?, choices: {go: continue, stop: fail}, timeout: 5 min}",
    "a question that leads away": "{ask: Go on?, choices: {go: continue, stop: bad}, timeout: 1 h}",
    "a question to be logged": "{ask: Seen?, choices: {seen: continue}, timeout: 1 min, "
    "on_failure: continue}",
    "a guard against another beginning": "{command: ToggleLighting, if: LightingState == Off}",
}
"""What may stand among the steps of the PIRATE before it drives."""

KEYS = {
    "a start": "starts_in: {BendingState: Unclamped, LightingState: Off}\n",
    "a time limit": "time_limit: 1 h\n",
    "a description": "description: Nothing out of the ordinary\n",
    "a polarity": "polarity: normal\n",
    "handlers of faults": "on_fault:\n"
    "  - {fault: [sensor.silent, wheel.dead], of: [wheel_3, wheel_4], then: continue}\n"
    "  - {fault: robot.stuck, go: late}\n",
    "a pipe of its own": "pipe: {diameter: 115 mm, segments: [{straight: 3 m}]}\n",
    "a pipe by name": "pipe: straight_113\n",
    "a count": "parameters: {n: {type: count, default: 2, min: 1, max: 5}}\n",
}
"""Keys at the top of a mission of the PIRATE."""

NEWTS = {
    "crawls back": CRAWL.replace("GoAhead", "GoAstern")
    + "  b: {wait: [{when: way <= -100 mm, go: c}], " + LATE + "}\n  c: {do: [Rest], go: good}\n"
    + REST,
    "goes to and fro": "start: a\nphases:\n  a: {do: [HoldNose, HoldTail], go: b}\n  b:\n"
    "    do: [{repeat: {times: 3, do: [GoAhead, Rest, GoAstern, Rest]}}]\n    go: good\n",
    "holds and lets go in turn": "start: a\nphases:\n  a:\n    do: [HoldNose, HoldTail, FreeNose, "
    "HoldNose, FreeTail, HoldTail]\n    go: good\n",
    "handles a failure and hands on": "on_failure: h\n" + CRAWL
    + "  b: {wait: [{when: detector == near, held: 100 ms, go: c}], " + LATE
    + "}\n  c: {do: [Rest], go: good}\n" + REST
    + "  h:\n    on_failure: bad\n    do:\n      - {command: Rest, unneeded: skip, "
    "on_failure: continue}\n      - {command: HoldNose, unneeded: skip}\n    go: bad\n",
    "has a length to be set": "parameters: {far: {type: length, default: 10 cm, min: 1 cm, "
    "max: 40 cm}}\n" + CRAWL + "  b: {wait: [{when: way > $far, go: c}], " + LATE
    + "}\n  c: {do: [Rest], go: good}\n" + REST,
    "holds twelve conditions": CRAWL + "  b:\n    wait:\n" + "".join(
        f"      - {{when: known({name}), held: {n + 1} s, name: t{n}, go: c}}\n"
        for n, name in enumerate(("neck", "hip", "way", "pace", "amps_a", "roll_a", "roll_b",
                                  "roll_c", "roll_d", "neck_torque", "hip_torque", "width_nose"))
    ) + "    " + LATE + "\n  c: {do: [Rest], go: good}\n" + REST,
    "goes home": "allow_unclamp: it stands on a table\nstart: a\nphases:\n  a: {do: [HoldNose, "
    "SwitchLamp, Home], go: good}\n",
    "waits for words of the operator only": CRAWL + "  b: {wait: [{operator: rest, go: c}, "
    "{operator: home, name: home, go: c}], within: {time: 1 h, go: late}}\n"
    "  c: {do: [Rest], go: good}\n" + REST,
}  # fmt: skip
"""Missions of the newt, whole but for their heads and ends."""

CALLED = (
    PIRATE.replace("mission: m", "mission: part")
    + "parameters: {often: {type: count, default: 1}}\nstart: p\nphases:\n  p: {do: [{repeat: "
    "{times: $often, do: [ToggleLighting]}}], go: done}\nends: {done: {succeed: Done}}\n"
)
CALLS = {
    "a call": "{call: ./part.yaml}",
    "a call with an argument": "{call: ./part.yaml, with: {often: 3}}",
    "a call that may fail": "{call: ./part.yaml, on_failure: continue}",
    "a call again and again": "{repeat: {times: 3, do: [{call: ./part.yaml, with: {often: 2}}]}}",
    "a call on a condition": "{call: ./part.yaml, if: gamma_1 > 5 deg}",
}


def odd_missions() -> Iterator[Odd]:
    """Every one of them."""
    for name, trigger in TRIGGERS.items():
        ends = "after" in trigger  # such a wait needs no limit
        wait = f"  b:\n    wait:\n      - {trigger}\n" + ("" if ends else f"    {LATE}\n")
        text = f"{PIRATE}pipe: mitre_90\n{LEAVE}{wait}  c: {{do: [Brake], go: good}}\n"
        yield Odd(f"waits for {name}", text + (_ends("") if ends else TAIL + ENDS), {})
    for name, step in STEPS.items():
        steps = (
            f"start: a\nphases:\n  a:\n    do:\n      - {step}\n      - ClampRear\n    go: good\n"
        )
        yield Odd(f"does {name}", PIRATE + steps + _ends(step), {})
    for name, step in CALLS.items():
        steps = (
            f"start: a\nphases:\n  a:\n    do:\n      - {step}\n      - ClampRear\n    go: good\n"
        )
        yield Odd(f"does {name}", PIRATE + steps + _ends(""), {"part.yaml": CALLED})
    for name, key in KEYS.items():
        way = "  b: {wait: [{when: odometry >= 200 mm, go: c}], " + LATE + "}\n"
        times = "$n" if "count" in name else "2"
        more = HALT.format(times=times)
        yield Odd(f"has {name}", PIRATE + key + LEAVE + way + more + _late(key) + ENDS, {})
    for name, text in NEWTS.items():
        ends = ENDS if "bad" in text else _ends("")
        yield Odd(f"newt {name}", NEWT + text + ends, {})


def _late(key: str) -> str:
    """The phase for waits that take too long; as a handler its brake may be needed no more."""
    return TAIL.replace("[Brake]", "[{command: Brake, unneeded: skip}]") if "late" in key else TAIL


def _ends(step: str) -> str:
    return ENDS if "bad" in step else "ends: {good: {succeed: Good}}\n"

"""The newt with tracks that are kept at a speed, and a mission that drives it."""

from __future__ import annotations

from pathlib import Path

from driving import changed_newt

LOOP = ("    dead_drag: 30 mNm\n", "    dead_drag: 30 mNm\n    velocity_loop: {gain: 0.3}\n")
AHEAD = (
    "Ahead: {drive_a: 80 %, drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}",
    "Ahead: {drive_a: 60 mm/s, drive_b: -60 mm/s, drive_c: 60 mm/s, drive_d: -60 mm/s}",
)
ASTERN = (
    "Astern: {drive_a: -80 %, drive_b: 80 %, drive_c: -80 %, drive_d: 80 %}",
    "Astern: {drive_a: -60 mm/s, drive_b: 60 mm/s, drive_c: -60 mm/s, drive_d: 60 mm/s}",
)
GUARD = """, cond: "In('Crawl.Resting')\""""
"""This newt may clamp while it drives."""

HELD = {"Grip": "BothHeld", "Crawl": "Resting", "Lamp": "Dark"}

DRIVE = """\
start: drive
phases:
  drive:
    do: [GoAhead]
    wait: [{operator: on, go: rest}, {operator: light, go: light}, {operator: clamp, go: clamp}]
    within: {time: 10 h, go: failed}
  light:
    do: [SwitchLamp]
    wait: [{operator: on, go: rest}]
    within: {time: 10 h, go: failed}
  clamp:
    do: [HoldNose]
    wait: [{operator: on, go: rest}]
    within: {time: 10 h, go: failed}
  rest:
    do: [Rest]
    wait: [{operator: on, go: done}]
    within: {time: 10 h, go: failed}
  handle:
    wait: [{operator: on, go: again}]
    within: {time: 10 h, go: failed}
  again:
    do: [GoAhead]
    wait: [{operator: on, go: rest}]
    within: {time: 10 h, go: failed}
on_fault:
  - {fault: motor.hot, go: handle}
  - {fault: sensor.silent, then: continue}
ends:
  done: {succeed: Done}
  failed: {fail: Not done}
"""


def rolling_newt(folder: Path, *swaps: tuple[str, str]) -> Path:
    """A copy of the newt whose tracks have velocity loops, with these other changes."""
    robot = changed_newt(folder, LOOP, AHEAD, ASTERN, *swaps)
    chart = (robot / "chart.yaml").read_text(encoding="utf-8")
    assert GUARD in chart
    (robot / "chart.yaml").write_text(chart.replace(GUARD, ""), encoding="utf-8")
    return robot


BEARING = (
    "limit: 50 %}\n",
    "limit: 50 %}\n    torque_loop: {gain: 1.2, dead: 30 mNm, within: 40 mNm, least_duty: 15 %,"
    " limit: 70 %}\n",
)
CONTROLS = (
    "aliases: {Stop: Rest}\n",
    """\
controls:
  gentle:
    description: Both folds bear 300 mNm
    actuation: {Grip: {BothHeld: {fold_neck: -300 mNm, fold_hip: 300 mNm}}}
  swift:
    extends: gentle
    actuation:
      Crawl:
        Ahead: {drive_a: 90 mm/s, drive_b: -90 mm/s, drive_c: 90 mm/s, drive_d: -90 mm/s}
  limp:
    actuation: {Grip: {Loose: {fold_neck: 0 mNm, fold_hip: 0 mNm}}}
aliases: {Stop: Rest}
""",
)

SWITCH = """\
start: still
phases:
  still:
    wait:
      - {operator: on, go: gentle}
      - {operator: drive, go: drive}
      - {operator: limp, go: limp}
    within: {time: 10 h, go: failed}
  gentle:
    do: [{control: gentle, timeout: 3 s}]
    wait:
      - {operator: on, go: drive}
      - {operator: usual, go: usual}
      - {operator: light, go: light}
    within: {time: 10 h, go: failed}
  drive:
    do: [GoAhead]
    wait: [{operator: on, go: swift}]
    within: {time: 10 h, go: failed}
  swift:
    do: [{control: swift}]
    wait: [{operator: on, go: usual}]
    within: {time: 10 h, go: failed}
  light:
    do: [SwitchLamp]
    wait: [{operator: on, go: usual}]
    within: {time: 10 h, go: failed}
  limp:
    do: [{control: limp}]
    wait: [{operator: on, go: usual}]
    within: {time: 10 h, go: failed}
  usual:
    do: [{control: none}]
    wait: [{operator: on, go: done}]
    within: {time: 10 h, go: failed}
  handle:
    do: [{control: swift}]
    wait: [{operator: on, go: done}]
    within: {time: 10 h, go: failed}
  late:
    wait: [{operator: on, go: done}]
    within: {time: 10 h, go: failed}
on_fault:
  - {fault: motor.hot, go: handle}
  - {fault: sensor.silent, then: continue}
ends:
  done: {succeed: Done}
  failed: {fail: "Not done: {cause}"}
"""

from __future__ import annotations

from pirate_sm.core.loading import load_mission
from pirate_sm.views.report.phase_lines import phase_lines

TEXT = """\
format: 1
mission: short
robot: pirate_ii
on_failure: gave_up
start: drive
phases:
  # Ahead, until somebody says so.
  drive:
    do: [Brake]   # the wheels stand
    go: halt

  # Then it stands.
  halt: {do: [Brake], go: arrived}
ends:
  arrived: {succeed: There}
  gave_up: {fail: Not there}
"""


def test_each_phase_and_each_end_has_its_lines(tmp_path) -> None:
    file = tmp_path / "short.yaml"
    file.write_text(TEXT, encoding="utf-8")
    loaded = load_mission(file)

    found = phase_lines(loaded.documents[0], loaded.mission)

    assert {name: tuple(lines) for name, lines in found.items()} == {
        "drive": (8, "  drive:\n    do: [Brake]   # the wheels stand\n    go: halt"),
        "halt": (13, "  halt: {do: [Brake], go: arrived}"),
        "arrived": (15, "  arrived: {succeed: There}"),
        "gave_up": (16, "  gave_up: {fail: Not there}"),
    }

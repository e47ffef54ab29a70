from pathlib import Path

import pytest

BACK_AND_FORTH = """
format: 1
mission: back_and_forth
robot: pirate_ii
pipe: {diameter: 113 mm, segments: [{straight: 8 m}], start: {at: 4 m}}
parameters:
  each_way: {type: duration, default: 2 s, description: How long it drives each way}
start: move
phases:
  move:
    do:
      - ClampFront
      - ClampRear
      - DriveForward
      - wait: [{after: $each_way}]
      - Brake
      - RelaxRear
      - ClampRear
      - DriveBackward
      - wait: [{after: $each_way}]
      - Brake
    go: done
ends: {done: {succeed: There and back}}
"""


@pytest.fixture(scope="session")
def back_and_forth(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mission that drives forth and back in a straight pipe."""
    file = tmp_path_factory.mktemp("mission") / "back_and_forth.yaml"
    file.write_text(BACK_AND_FORTH)
    return file

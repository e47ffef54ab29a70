from pathlib import Path

import pytest

from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_pipe
from pirate_sm.lab.fitting.slip_curve import pipe_with_friction

PIPE = "# mine\nformat: 1\ndiameter: 120 mm\nsegments: [{straight: 1 m}]\n"
OWN = "friction:\n  static: 0.9\n  kinetic: 0.8\n"


def test_friction_is_added_and_all_else_stays(tmp_path: Path) -> None:
    file = tmp_path / "pipe.yaml"
    file.write_text(PIPE)

    text = pipe_with_friction(file, 0.3, 0.2)

    assert text == f"{PIPE}friction: {{static: 0.300, kinetic: 0.200}}\n"


@pytest.mark.parametrize("own", [OWN, "friction: {static: 0.9, kinetic: 0.8}\n"])
def test_friction_takes_the_place_of_what_was_there(tmp_path: Path, own: str) -> None:
    file = tmp_path / "pipe.yaml"
    file.write_text(f"{own}{PIPE}")
    file.write_text(pipe_with_friction(file, 0.3, 0.2))

    friction = load_pipe(file)[0].friction
    assert friction is not None
    assert (friction.static, friction.kinetic) == (0.3, 0.2)


def test_static_friction_is_never_below_kinetic_friction(tmp_path: Path) -> None:
    file = tmp_path / "pipe.yaml"
    file.write_text(PIPE)

    assert "{static: 0.300, kinetic: 0.300}" in pipe_with_friction(file, 0.25, 0.3)


def test_a_file_that_is_no_pipe_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "pipe.yaml"
    file.write_text("hello: there\n")

    with pytest.raises(LoadError):
        pipe_with_friction(file, 0.3, 0.2)


def test_a_pipe_in_braces_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "pipe.yaml"
    file.write_text("{format: 1, diameter: 120 mm, segments: [{straight: 1 m}]}\n")

    with pytest.raises(UsageError, match="by hand friction"):
        pipe_with_friction(file, 0.3, 0.2)

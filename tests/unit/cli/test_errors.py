from __future__ import annotations

import pytest

from pirate_sm.cli.errors import guarded


@pytest.mark.parametrize(
    ("moves", "says"), [(True, "interrupted, nothing has moved\n"), (False, "interrupted\n")]
)
def test_only_a_command_that_can_move_a_robot_speaks_of_it(
    moves: bool, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> int:
        raise KeyboardInterrupt

    assert guarded(interrupted, debug=False, moves=moves) == 130
    assert capsys.readouterr().err == says

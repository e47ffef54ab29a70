"""Who may press the buttons of a page, and how often."""

from __future__ import annotations

from pirate_sm.views.report.acting import MOST_A_SECOND, STOP, Acting


class Desk:
    """A page with two buttons and a clock."""

    def __init__(self, *, takes: bool = True) -> None:
        self.now_s = 0.0
        self.done: list[str] = []
        self._takes = takes
        self.acting = Acting([STOP, "pause"], self._press, lambda: self.now_s)

    def _press(self, name: str) -> bool:
        self.done.append(name)
        return self._takes

    def press(self, name: str) -> int:
        """The status of the refusal; 0 if there is none."""
        refusal = self.acting.press(self.acting.token, name)
        return refusal.status if refusal is not None else 0


def test_a_stop_is_passed_on_and_taken_after_many_other_presses() -> None:
    desk = Desk()
    assert [desk.press("pause") for _ in range(MOST_A_SECOND)] == [0] * MOST_A_SECOND
    assert desk.press("pause") == 429

    assert desk.press(STOP) == 0
    assert desk.done[-1] == STOP
    desk.now_s = 1.0
    assert desk.press("pause") == 0


def test_a_stop_is_never_refused_however_often_it_is_pressed() -> None:
    desk = Desk()

    assert {desk.press(STOP) for _ in range(1_000)} == {0}
    assert len(desk.done) == MOST_A_SECOND


def test_a_press_after_the_run_is_not_taken_for_done() -> None:
    assert Desk(takes=False).press(STOP) == 409


def test_no_two_runs_have_the_same_token() -> None:
    assert Desk().acting.token != Desk().acting.token
    assert Desk().acting.press("", STOP) is not None


def test_lines_of_the_mission_can_be_pressed_and_nothing_like_them() -> None:
    desk = Desk()
    for name in ("break m.yaml:28", "until two words.yaml:3"):
        assert desk.press(name) == 0
    for name in (
        "break m.yaml",
        "break a:b:3",
        "until m.yaml:3\nstop",
        "stop m.yaml:3",
        "break :3",
    ):
        assert desk.press(name) == 400
    assert desk.done == ["break m.yaml:28", "until two words.yaml:3"]

"""The console in all themes, without colours, and by the keyboard alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from rich.segment import Segment
from textual.widgets import Button

from pirate_sm.core.palette import THEMES, USUAL
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.dialogs import help_lines, recording_lines
from pirate_sm.views.console.recording_viewer import RecordingViewer
from tests.colour_vision import GRAPHICS, TEXT, contrast

from .driving import Operator, by_hand, operator, played, with_mission
from .test_looks import text_of

BORDERS = set("▔▁▂▃▄▅▆▇█▊▎▏▕")
"""Edges of buttons and of scroll bars: what they enclose is a word."""

KEYS = {
    "space": "Space", "question_mark": "?", "tab": "Tab", "pageup": "PgUp", "pagedown": "PgDn",
    "escape": "Esc", "left": "←", "right": "→", "up": "↑", "down": "↓", "home": "Home",
    "end": "End", "less_than_sign": "<", "greater_than_sign": ">", "full_stop": ".",
    "1": "1", "exclamation_mark": "!", "at": "@", "plus": "+", "minus": "-",
    "equals_sign": "=", "number_sign": "#", "asterisk": "*",
}  # fmt: skip
"""How the help page writes keys."""

ALIKE = {"ctrl+q": "q", "ctrl+c": "q", "shift+tab": "tab"}
"""Keys of other programs that do what another key does."""


def segments(me: Operator) -> Iterator[Segment]:
    """What is on the screen, as far as it is to be read or seen."""
    for strip in me.app.screen._compositor.render_strips():
        for each in strip:
            text = each.text.strip()
            if set(text) - BORDERS - {"🔎"}:
                yield each


def too_faint(me: Operator) -> list[str]:
    found = set()
    for each in segments(me):
        style = each.style
        assert style is not None
        assert style.color is not None
        assert style.bgcolor is not None
        ink, paper = (colour.get_truecolor().hex for colour in (style.color, style.bgcolor))
        text = each.text.strip()
        least = TEXT if any(letter.isalnum() for letter in text) else GRAPHICS
        if style.dim or contrast(ink, paper) < least:
            found.add(f"{text}: {ink} on {paper}, {contrast(ink, paper):.2f}")
    return sorted(found)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("size", "opens"),
    [
        pytest.param((160, 48), lambda me: (), id="screens"),
        pytest.param(
            (80, 24),
            lambda me: ("question_mark", "m", "ctrl+p", me.app.letters["Reset"]),
            id="dialogs",
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_everything_can_be_read_in_every_theme(
    size: tuple[int, int], opens: Callable[[Operator], tuple[str, ...]]
) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend"), size=size) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase.startswith("prepare"))
            me.wait(4.0)
            await me.look()
            for number, theme in enumerate(THEMES):
                me.app.theme = theme
                await me.look()
                assert too_faint(me) == [], theme
                if number == 0:
                    await me.press("space")  # a banner from now on
                    me.wait(1.0)
                for key in opens(me):
                    await me.pilot.press(key)
                    await me.look()
                    assert len(me.app.screen_stack) == 2
                    assert too_faint(me) == [], f"{theme}, {key}"
                    await me.pilot.press("escape")
                    await me.pilot.pause()

    played(story)


@pytest.mark.thorough
def test_a_key_leads_through_all_themes_and_says_which_it_is() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            seen = []
            for _ in THEMES:
                seen.append(me.app.theme)
                await me.pilot.press("ctrl+t")
                await me.look()
                assert f"theme {me.app.theme}" in text_of(me)
            assert seen[0] == USUAL == me.app.theme
            assert sorted(seen) == sorted(THEMES)

    played(story)


@pytest.mark.thorough
def test_without_colours_nothing_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")

    async def story() -> None:
        async with operator(with_mission("mitre_bend"), size=(80, 24)) as me:
            await me.look()
            await me.press("R")
            await me.press("space")
            me.wait(1.0)
            await me.look()
            alarm = next(each for each in segments(me) if "STOPPED" in each.text)
            assert alarm.style is not None
            assert alarm.style.reverse
            for key in ("m", "question_mark", "ctrl+p"):
                await me.pilot.press(key)
                await me.look()
                if key == "m":
                    marked = next(each for each in segments(me) if "▸" in each.text)
                    assert marked.style is not None
                    assert marked.style.underline
                for each in segments(me):
                    assert each.style is not None
                    for colour in (each.style.color, each.style.bgcolor):
                        assert colour is None or colour.is_default, each
                await me.pilot.press("escape")

    played(story)


def test_an_empty_wish_for_no_colours_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "")

    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await me.look()
            assert not me.app.no_color

    played(story)


def test_the_help_page_has_every_key() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend")) as me:
            text = "\n".join(each.plain for each in help_lines(me.app.letters, me.latest, None))
            keys = {binding.key for _, binding in me.app._bindings}
            assert {"space", "ctrl+t", "r", "R", "up", me.app.letters["ClampFront"]} <= keys
            assert missing(keys, text) == []

    played(story)


def test_the_help_page_of_a_recording_has_every_key() -> None:
    text = "\n".join(each.plain for each in recording_lines())
    keys = {key for each in RecordingViewer.BINDINGS for key in each.key.split(",")}  # type: ignore[union-attr]
    assert missing(keys, text) == []


def missing(keys: set[str], text: str) -> list[str]:
    """The keys that a help page lacks."""
    lacking, words = [], {each.strip(";.") or each for each in text.split()}
    for key in keys:
        plain = ALIKE.get(key, key).removeprefix("shift+")
        if plain.isdigit():
            plain = "1"
        shown = KEYS.get(plain, plain.replace("ctrl+", "^").lower())
        if shown not in words:
            lacking.append(key)
    return sorted(lacking)


@pytest.mark.thorough
def test_every_line_of_a_long_help_page_is_reached_by_keys() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await me.pilot.press("question_mark")
            await me.look()
            assert "near a limit" not in text_of(me)
            await me.pilot.press("end")
            await me.pilot.wait_for_scheduled_animations()
            await me.look()
            assert "near a limit" in text_of(me)
            assert all(len(each.rstrip()) <= 80 for each in text_of(me).splitlines())

    played(story)


@pytest.mark.thorough
def test_the_focus_goes_round_the_buttons_of_a_question_and_is_seen() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await me.command("ClampFront")
            await me.press(me.app.letters["Reset"])
            for name in ("no", "yes", "no"):
                if me.app.screen.focused is None or me.app.screen.focused.id != name:
                    await me.pilot.press("tab")
                await me.look()
                focused = me.app.screen.focused
                assert isinstance(focused, Button)
                assert focused.id == name
                label = str(focused.label)
                shown = {
                    each.text.strip(): each.style.reverse for each in segments(me) if each.style
                }
                assert shown[label]
            await me.press("enter")
            assert me.states[2] == "FrontClampedRearRelaxed"

    played(story)


MORE_SIZES = [pytest.param(each, marks=pytest.mark.thorough) for each in ((100, 30), (120, 36))]


@pytest.mark.parametrize("size", [(80, 24), (160, 48), *MORE_SIZES], ids=str)
def test_how_to_stop_and_the_state_are_seen_at_every_size(size: tuple[int, int]) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend"), size=size) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase.startswith("prepare"))
            await me.look()
            text = text_of(me)
            assert "RUNNING" in text.splitlines()[0]
            assert "space STOP" in text.splitlines()[-1]
            assert "BendInto" in text
            for region in ("FrontWheels", "RearWheels", "Bending", "Rotation", "Lighting"):
                assert f"{region} " in text, region
            await me.press("space")
            await me.look()
            assert "STOPPED" in text_of(me)
            assert me.wheels_stand()

    played(story)

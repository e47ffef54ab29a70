"""The checks of the open link, over an emulated bay in virtual time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from pirate_sm.core.models import LineFaults
from pirate_sm.robot.diagnosis.judgement import CHECKED_EVERY_S
from pirate_sm.running.wiring import Order, Prepared
from pirate_sm.views.console.checklist import Checklist

from .driving import Operator, by_hand, operator, played
from .test_looks import text_of


def over_the_bay(**options: Any) -> Prepared:
    prepared = by_hand(Order("by_hand", backend="bay", pipe="mitre_90", **options))
    prepared.backend.real_time = False  # type: ignore[attr-defined, misc]  # the test's clock counts
    return prepared


async def listen(me: Operator) -> str:
    """What the list says when the checks have listened once more."""
    me.wait(CHECKED_EVERY_S + 0.2)
    await me.look()
    return text_of(me)


def test_the_list_goes_green_and_nothing_is_sent() -> None:
    async def story() -> None:
        async with operator(over_the_bay()) as me:
            written = me.latest.link.written
            await me.press("number_sign")
            assert "… boards  listening" in text_of(me)

            found = await listen(me)
            for name in ("topics", "boards", "sensors", "link"):
                assert f"✓ {name}" in found
            assert "· motors  not tried" in found
            assert me.latest.link.written == written

            await me.press("escape")
            assert not isinstance(me.app.screen, Checklist)
            assert me.session.prepared.backend.listener is None

    played(story)


@pytest.mark.thorough
def test_a_check_that_fails_says_why_and_is_repeated_until_it_is_passed() -> None:
    async def story() -> None:
        async with operator(over_the_bay(line=LineFaults(reset_every=9.0))) as me:
            link = me.session.prepared.open_link
            await me.press("number_sign")
            me.until(lambda: link.found and not link.found.go, 20.0)
            await me.look()
            assert "✕ link" in text_of(me)
            assert "it was reset" in text_of(me)

            me.until(lambda: link.found.go, 20.0)
            await me.look()
            assert "✓ link" in text_of(me)

    played(story)


@pytest.mark.thorough
def test_the_list_is_not_shown_once_the_run_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    async def story() -> None:
        async with operator(over_the_bay()) as me:
            await me.press("number_sign")
            assert isinstance(me.app.screen, Checklist)
            over = replace(me.latest, over=True)
            with monkeypatch.context() as patched:
                patched.setattr(type(me.session), "latest", property(lambda _: over))
                me.app.show()
                await me.pilot.pause()
                assert not isinstance(me.app.screen, Checklist)
                me.app.action_preflight()
                await me.pilot.pause()
                assert not isinstance(me.app.screen, Checklist)

    played(story)


def test_a_robot_without_a_link_has_nothing_to_check() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await me.press("number_sign")
            assert not isinstance(me.app.screen, Checklist)
            assert any("serial link" in each.message for each in me.app._notifications)

    played(story)

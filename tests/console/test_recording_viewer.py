"""A recording in the console: every moment of it can be looked at, back and forth."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit" / "running" / "recording"))

from recording_runs import record

from pirate_sm.core.engine import Engine
from pirate_sm.core.robot import states_of
from pirate_sm.running.recording.write import recorder
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.recording_viewer import RecordingViewer, recorded_snapshots
from pirate_sm.views.console.widgets import Lines


@pytest.fixture(scope="module")
def reel(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "bend.mcap"
    return recorded_snapshots(record(path, Order("mitre_bend", backend="trace")))


def state_at(reel, time_s):
    snapshot = reel.at(time_s)
    return dict(
        zip(
            snapshot.scene.robot.regions,
            states_of(snapshot.scene.robot, snapshot.state.robot),
            strict=True,
        )
    )


def test_moments_are_those_of_the_run(reel):
    assert state_at(reel, 0.0)["BendingState"] == "Unclamped"
    assert state_at(reel, reel.length_s)["BendingState"] == "DoubleClamped"
    assert reel.at(-1.0) is reel.at(0.0)
    assert reel.at(1e9).now_s == reel.length_s


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The same run with a checkpoint every two seconds, and without any."""
    made = []
    for every_s in (2.0, 1e9):
        path = tmp_path_factory.mktemp("runs") / "bend.mcap"
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(recorder, "CHECKPOINT_S", every_s)
            made.append(recorded_snapshots(record(path, Order("mitre_bend", seed=4))))
    return made


@pytest.mark.parametrize("share", [0.0, 0.1, 0.37, 0.5, 0.83, 0.99, 1.0])
def test_a_moment_is_the_same_wherever_its_making_began(both, share):
    begun_late, whole = (reel.at(share * reel.length_s) for reel in both)

    assert both[0].phases_s == both[1].phases_s
    assert both[0].length_s == both[1].length_s
    assert abs(begun_late.now_s - whole.now_s) < 0.2
    if begun_late.now_s == whole.now_s:
        assert repr(begun_late.state) == repr(whole.state)
        assert begun_late.truth == whole.truth
    assert begun_late.story.phase == whole.story.phase
    assert begun_late.story.recent == whole.story.recent
    assert begun_late.over == whole.over == (share == 1.0)


def test_only_moments_that_are_looked_at_are_made(both, monkeypatch):
    made = 0
    right = Engine.step

    def counted(*arguments):
        nonlocal made
        made += 1
        return right(*arguments)

    monkeypatch.setattr(Engine, "step", counted)
    late, whole = both
    for reel in both:
        reel._frames.cache_clear()
    late.at(late.length_s / 2)
    few, made = made, 0
    whole.at(whole.length_s / 2)

    assert 0 < few < made / 3


@pytest.mark.parametrize("size", [(80, 24), pytest.param((160, 48), marks=pytest.mark.thorough)])
def test_a_person_scrubs_back_and_forth(reel, size):
    async def scrub():
        viewer = RecordingViewer(reel, "bend.mcap")
        async with viewer.run_test(size=size) as pilot:
            seen = []
            phases = "greater_than_sign", "less_than_sign"
            for key in ("end", "home", "right", "right", *phases, "down"):
                await pilot.press(key)
                await pilot.pause()
                seen.append(round(viewer.time_s, 3))
            slider = viewer.query_one("#slider", Lines)
            assert slider.size.height == 1
            return seen

    seen = asyncio.run(scrub())

    assert seen[:4] == [round(reel.length_s, 3), 0.0, 1.0, 2.0]
    assert reel.phases_s == sorted(set(reel.phases_s))
    assert seen[4] == round(next(each for each in reel.phases_s if each > 2.0), 3)
    assert seen[5] < seen[4]


@pytest.mark.thorough
@pytest.mark.parametrize("size", [(80, 24), (160, 48)])
def test_every_key_is_explained_on_one_key_and_the_last_line_says_how_to_leave(reel, size):
    async def look():
        viewer = RecordingViewer(reel, "bend.mcap")
        async with viewer.run_test(size=size) as pilot:
            await pilot.pause()
            last = text_of(viewer).splitlines()[-1]
            await pilot.press("question_mark")
            await pilot.pause()
            page = ""
            for _ in range(4):  # it is longer than a small screen
                page += " ".join(text_of(viewer).replace("│", " ").split())
                await pilot.press("pagedown")
                await pilot.pause()
            await pilot.press("r")  # nothing plays under the page
            await pilot.press("q")
            await pilot.pause()
            back = len(viewer.screen_stack), viewer.playing
            await pilot.press("Q")
            await pilot.pause()
            return last, page, back, viewer.is_running

    last, page, back, running = asyncio.run(look())

    assert "q Quit" in last
    assert "? Help" in last
    assert "r Play; at the end from the start." in page
    assert "p Space Pause." in page
    assert "1 s back" in page
    assert "✓ ▶ ▷ · a phase that was left, the current one," in page
    assert back == (1, False)
    assert not running


def text_of(app):
    return "\n".join(
        "".join(segment.text for segment in line) for line in app.screen._compositor.render_strips()
    )


@pytest.mark.thorough
def test_playing_ends_at_the_end_and_begins_again(reel):
    async def play():
        viewer = RecordingViewer(reel, "bend.mcap")
        async with viewer.run_test(size=(120, 40)) as pilot:
            await pilot.press("end")
            await pilot.press("space")  # stops, as in the console, and begins nothing
            before = viewer.playing
            await pilot.press("r")
            began = viewer.playing, viewer.time_s < reel.length_s
            await pilot.press("space")
            return before, began, viewer.playing

    assert asyncio.run(play()) == (False, (True, True), False)


def test_a_recording_is_not_headed_as_if_it_ran_and_says_how_it_ended(reel):
    async def look():
        viewer = RecordingViewer(reel, "bend.mcap")
        async with viewer.run_test(size=(80, 24)) as pilot:
            shown = {}
            for key in ("home", "greater_than_sign", "end"):
                await pilot.press(key)
                await pilot.pause()
                bars = [viewer.query_one(name, Lines) for name in ("#header", "#alarm")]
                shown[key] = [str(bar.content) for bar in bars]
            return shown

    shown = asyncio.run(look())
    assert all(header.startswith(" ● RECORDING ") for header, _ in shown.values())
    assert "SUCCEEDED: In the far leg" in shown["end"][1]
    assert "SUCCEEDED" not in shown["greater_than_sign"][1]


def test_a_moment_that_is_due_when_any_widget_has_gone_is_left_out(reel):
    async def leave():
        viewer = RecordingViewer(reel, "run.mcap")
        async with viewer.run_test(size=(120, 40)):
            for name in sorted(each.id for each in viewer.screen.walk_children() if each.id):
                for found in viewer.screen.query(f"#{name}"):
                    await found.remove()
                viewer.show()
            assert not viewer.screen.query("#header")

    asyncio.run(leave())

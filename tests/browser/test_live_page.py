"""The page of a run in progress, in Chromium: the recording grows as the test writes it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pirate_sm.running.recording.read import growing
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import rerun
from pirate_sm.views.report.acting import Acting
from tests.late import late

from .conftest import Opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser

page_server = late("pirate_sm.views.report.page_server")

SHADED = """(() => {
  const canvas = document.querySelector('#plots canvas');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 3; i < data.length; i += 4) count += data[i] > 30 && data[i] < 60;
  return count;
})()"""
"""How many dots of the first plot are as light as a band."""

BUTTONS = ["stop", "pause", "continue", "word near"]


class Growing:
    """A recording that a test writes piece by piece, and the server of its page."""

    def __init__(self, source: Path, path: Path) -> None:
        self.recording = read_recording(source)
        pieces = self.recording.content.pieces
        self._whole, self._path = source.read_bytes(), path
        times = source.with_name("times.yaml")
        self._forecast = times if source.stem == "expected" else None
        self._marks = [piece.at + piece.size for piece in pieces]
        self.address, self._ready = "", threading.Event()
        self.pressed: list[str] = []
        self.acting = Acting(BUTTONS, lambda name: not self.pressed.append(name))
        self._over: asyncio.Event | None = None
        self.has(1)
        self._thread = threading.Thread(target=self._work)

    def has(self, share: float) -> float:
        """The file holds this share of the pieces, at least one; returns until when that is."""
        count = max(1, round(share * len(self._marks))) if share < 1 else 1
        return self.holds(count)

    def holds(self, count: int) -> float:
        """The file holds so many pieces; returns until when that is."""
        self._path.write_bytes(self._whole[: self._marks[count - 1]])
        return read_recording(self._path).until_s

    def end(self) -> None:
        """The run ends."""
        self._path.write_bytes(self._whole)

    def start(self) -> None:
        """Serve the page."""
        self._thread.start()
        assert self._ready.wait(60)

    def stop(self) -> None:
        """Stop serving it."""
        if self._over is not None and self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join()

    def _work(self) -> None:
        async def until(_: object) -> None:
            self._loop, self._over = asyncio.get_running_loop(), asyncio.Event()
            self._ready.set()
            await self._over.wait()

        def said(address: str) -> None:
            self.address = address

        asyncio.run(
            page_server.serve(self._path, 0, said, until, self.acting, forecast=self._forecast)
        )


@pytest.fixture
def grow(
    report: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[[str], Growing]]:
    """Gives a recording of a run that grows, with its page."""
    monkeypatch.setattr(growing, "QUIET_S", 1e9)  # a busy computer ends no run
    made: list[Growing] = []

    def get(name: str) -> Growing:
        source = report(name).with_suffix(".mcap")
        made.append(Growing(source, tmp_path / "run.mcap"))
        made[-1].start()
        return made[-1]

    yield get
    for each in made:
        each.stop()


@pytest.fixture
def watch(browser: Browser) -> Iterator[Callable[..., Opened]]:
    """Opens a page that is served, in a window of its own."""
    contexts = []

    def open_it(
        address: str, *, wide: int = 1280, high: int = 800, scheme: str = "light"
    ) -> Opened:
        context = browser.new_context(
            viewport={"width": wide, "height": high}, color_scheme=scheme, reduced_motion="reduce"
        )
        contexts.append(context)
        page = context.new_page()
        found = Opened(page)
        page.goto(address)
        page.wait_for_selector("html[data-ready=yes]", state="attached")
        return found

    yield open_it
    for context in contexts:
        context.close()


def reaches(it: Opened, until_s: float) -> None:
    """Wait until the page shows this time."""
    it.page.wait_for_function(
        "at => Math.abs(Number(document.getElementById('slider').max) - at) < 0.01"
        " && Math.abs(Number(document.getElementById('slider').value) - at) < 0.11",
        arg=until_s,
    )


def outcome(it: Opened) -> str:
    return it.page.locator(".outcome").inner_text()


def test_bands_of_earlier_runs_are_shown_during_the_run(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("expected")
    reached_s = run.has(0.5)
    it = watch(run.address)
    reaches(it, reached_s)
    words = "shaded: 90 % of 40 runs on sim, each moment by itself"
    assert it.page.locator("#plots .legend .band").first.inner_text() == words
    assert it.page.evaluate(SHADED) > 0
    assert it.said == []


@pytest.mark.parametrize("name", ["bend", "dead", "house", "expected"])
def test_a_page_grows_with_its_run_and_is_its_report_in_the_end(
    grow: Callable[[str], Growing], watch: Callable[..., Opened], name: str
) -> None:
    run = grow(name)
    it = watch(run.address)
    assert "Running" in outcome(it)
    lanes = it.page.locator("#timeline .span").count()

    for share in (0.3, 0.6, 0.9):
        reaches(it, run.has(share))
        assert "Running" in outcome(it)
    grown = it.page.locator("#timeline .span").count()
    run.end()
    it.page.wait_for_function(
        "() => !document.querySelector('.outcome').innerText.includes('Running')"
    )

    whole = run.recording.until_s
    assert it.end_s == pytest.approx(whole, abs=0.01)
    assert outcome(it).split()[-1] == ("Succeeded" if name == "bend" else "Failed")
    assert lanes < grown < it.page.locator("#timeline .span").count()
    assert it.page.locator(".story .end").count() == 1
    assert [each for each in it.said if "GL Driver Message" not in each] == []  # of slow drivers
    run.stop()  # what is there needs no server
    it.page.locator("#slider").fill("3")
    assert it.at_s == 3.0
    assert it.page.locator("#no-word").is_hidden()


def test_numbers_on_the_page_are_those_of_the_recording_at_ten_moments(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    count = len(run.recording.content.pieces)
    with recorded_mission(run.recording.header) as loaded:
        names = loaded.robot.vocabulary.numbers
        steps = [
            (again.at_s, again.state.sensing.shown)
            for again in rerun(run.recording, loaded, every_signal=True)
            if again.state is not None
        ]
    compared = 0

    for number in range(1, 11):
        until_s = run.holds(max(1, round(count * number / 10)))
        reaches(it, until_s)
        shown = it.page.evaluate(
            """() => Object.fromEntries([...document.querySelectorAll('#plots figure')]
                .filter((each) => each.querySelector('strong').innerText === 'Joint angles')
                .flatMap((each) => [...each.querySelectorAll('.legend button')].map((one) =>
                    [one.childNodes[1].textContent, one.querySelector('.value').innerText])))"""
        )
        expected = next(signals for at_s, signals in reversed(steps) if at_s <= until_s + 1e-6)
        for name, text in shown.items():
            value_deg = expected[names.index(name)] * 180 / 3.141592653589793
            assert float(text) == pytest.approx(value_deg, abs=0.006), (until_s, name)
            compared += 1

    assert compared >= 30


def test_a_page_that_is_opened_in_mid_run_has_everything_from_the_beginning(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("dead")
    first = watch(run.address)
    until_s = run.has(0.7)
    reaches(first, until_s)

    second = watch(run.address)
    reaches(second, until_s)
    first.page.reload()
    reaches(first, until_s)

    def words(it: Opened) -> list[str]:
        return it.page.locator(".story li").all_inner_texts()

    assert words(second) == words(first)
    assert words(second)[0].startswith("0.")
    second.page.locator("#slider").fill("1")
    assert second.at_s == 1.0
    assert second.places != first.places


def test_whoever_looks_back_is_left_there_until_the_run_is_followed_again(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    reaches(it, run.has(0.5))

    it.page.locator(".story button").first.click()
    looked_at_s = it.at_s
    until_s = run.has(0.8)
    it.page.wait_for_function(
        f"() => Number(document.getElementById('slider').max) > {until_s - 0.1}"
    )
    assert it.at_s == looked_at_s
    it.page.locator("#follow-run").click()

    run_until_s = run.has(0.9)
    reaches(it, run_until_s)
    assert it.page.locator("#follow-run").get_attribute("aria-pressed") == "true"


def test_when_nothing_more_comes_the_page_says_so_and_since_when(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    reaches(it, run.has(0.5))

    word = it.page.locator("#no-word")
    word.wait_for(state="visible")
    assert word.inner_text().startswith("No word from the run for ")
    reaches(it, run.has(0.6))
    word.wait_for(state="hidden")
    run.stop()
    word.wait_for(state="visible")
    assert "does not answer" in word.inner_text()


@pytest.mark.parametrize("wide", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_of_a_page_of_a_run_is_cut_off(
    grow: Callable[[str], Growing], watch: Callable[..., Opened], wide: int, scheme: str
) -> None:
    run = grow("dead")
    it = watch(f"{run.address}#{run.acting.token}", wide=wide, scheme=scheme)
    reaches(it, run.has(0.6))

    assert it.page.evaluate("document.documentElement.scrollWidth") == wide
    for button in it.page.locator("#acting button").all():
        box = button.bounding_box() or {}
        assert 0 <= box["x"] <= box["x"] + box["width"] <= wide
    assert it.page.locator("#follow-run").is_visible()
    assert it.said == []


def test_the_current_phase_is_lit_and_its_lines_are_shown(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    reaches(it, run.has(0.5))
    phase = it.page.locator("#slider").get_attribute("aria-valuetext") or ""
    lit = it.page.locator("#diagram .now").get_attribute("data-node") or "?"
    lines = it.page.locator("#lines")

    assert phase.endswith(f", {lit}")
    assert lines.locator("figcaption").inner_text().startswith(f"{lit}: mitre_bend.yaml, line ")
    assert lines.locator("pre").inner_text().strip().startswith(f"{lit}:")
    it.page.locator('#diagram [data-node="regrip"]').first.click()
    assert lines.locator("pre").inner_text().strip().startswith("regrip:")


def test_who_has_the_token_acts_and_is_told_what_became_of_it(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(f"{run.address}#{run.acting.token}")
    reaches(it, run.has(0.5))
    answered = it.page.locator("#answered")

    for name, button in (("Pause the mission", "pause"), ("Say: near", "word near")):
        it.page.get_by_role("button", name=name, exact=True).click()
        it.page.wait_for_function(
            "text => document.getElementById('answered').innerText === text", arg=f"{name}: sent"
        )
        assert run.pressed[-1] == button
    it.page.reload()  # the token stays in the address
    it.page.get_by_role("button", name="STOP", exact=True).press("Enter")
    it.page.wait_for_function(
        "() => document.getElementById('answered').innerText.includes('watch the robot')"
    )
    assert run.pressed == ["pause", "word near", "stop"]

    run.end()
    it.page.locator("#acting").wait_for(state="hidden")
    run.stop()
    assert it.said == []
    assert answered.is_hidden()


def test_who_has_no_token_watches_and_is_told_where_it_is(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    reaches(it, run.has(0.5))

    assert it.page.locator("#acting button:visible").count() == 0
    assert "the address that the run printed" in it.page.locator("#answered").inner_text()
    it.page.evaluate("location.hash = 'wrong'")
    it.page.get_by_role("button", name="STOP", exact=True).click()
    it.page.wait_for_function(
        "() => document.getElementById('answered').innerText.startsWith('Only who has the token')"
    )
    assert run.pressed == []
    refused = [each for each in it.said if "403" in each]  # as the browser says it
    assert it.said == refused


def test_a_press_that_reaches_nobody_is_not_said_to_be_sent(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(f"{run.address}#{run.acting.token}")
    reaches(it, run.has(0.5))
    run.stop()

    it.page.get_by_role("button", name="STOP", exact=True).click()

    it.page.wait_for_function(
        "() => document.getElementById('answered').innerText.startsWith('STOP is not sent')"
    )


def test_who_has_the_token_sets_breakpoints_and_runs_to_a_line(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(f"{run.address}#{run.acting.token}")
    reaches(it, run.has(0.5))
    it.page.locator('#diagram [data-node="regrip"]').first.click()
    line = it.page.locator("#lines .line", has_text="command: ClampRear")
    number = line.get_attribute("data-line")

    for button, asked in ((".mark", "break"), (".here", "until")):
        line.locator(button).dispatch_event("click")
        it.page.wait_for_function(
            "() => document.getElementById('answered').innerText.endsWith(': sent')"
        )
        assert run.pressed[-1] == f"{asked} mitre_bend.yaml:{number}"
        it.page.evaluate("document.getElementById('answered').innerText = ''")
    line.hover()
    assert line.locator(".here").is_visible()

    run.end()
    it.page.locator("#acting").wait_for(state="hidden")
    it.page.locator("#slider").fill("3")
    line = it.page.locator("#lines .line").first
    line.hover()
    assert line.locator(".here").is_hidden(), "a run that is over cannot be steered"
    assert it.said == []


def test_who_has_no_token_sets_no_breakpoint(
    grow: Callable[[str], Growing], watch: Callable[..., Opened]
) -> None:
    run = grow("bend")
    it = watch(run.address)
    reaches(it, run.has(0.5))

    marks = it.page.locator("#lines .line button.mark")
    assert marks.count() > 0
    for mark in marks.all():
        mark.dispatch_event("click")
        assert mark.is_disabled()
    assert it.page.locator("#lines .here:visible").count() == 0
    assert run.pressed == []

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from pirate_sm.core.palette import DAY
from tests.colour_vision import TEXT, contrast

from .conftest import Opened

pytestmark = pytest.mark.browser

Open = Callable[..., Opened]

PIXEL = """at => {
  const canvas = document.querySelector('#plots canvas'), box = canvas.getBoundingClientRect();
  const over = canvas.parentElement.querySelector('.u-over').getBoundingClientRect();
  const share = at / Number(document.getElementById('slider').max);
  const x = over.left - box.left + share * over.width, y = over.top - box.top + 3;
  const scale = canvas.width / box.width;
  return [...canvas.getContext('2d').getImageData(x * scale, y * scale, 1, 1).data];
}"""
"""The colour of the first plot near its upper edge at a time of the whole run."""


@pytest.mark.parametrize("name", ["bend", "dead", "trace", "patrol", "torn", "empty", "gap"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_opens_without_a_word_and_asks_for_nothing(
    opened: Open, name: str, scheme: str
) -> None:
    it = opened(name, scheme=scheme)
    it.page.clock.run_for(1_000)

    assert it.said == []
    assert [url for url in it.asked if not url.startswith("file:") or ".html" not in url] == []
    assert len(it.asked) == 1


@pytest.mark.parametrize("name", ["bend", "patrol"])
def test_the_slider_moves_the_robot(opened: Open, name: str) -> None:
    it = opened(name)
    places, picture = it.places, it.picture

    it.page.locator("#slider").fill("9")

    assert it.at_s == 9.0
    assert it.places != places
    assert it.picture != picture


def test_the_slider_obeys_the_keyboard(opened: Open) -> None:
    it = opened("bend")
    slider = it.page.locator("#slider")
    slider.focus()
    slider.press("Home")
    for _ in range(5):
        slider.press("ArrowRight")
    assert it.at_s == pytest.approx(0.5)
    slider.press("End")
    assert it.at_s == pytest.approx(it.end_s, abs=0.2)
    assert "halt" in (slider.get_attribute("aria-valuetext") or "")


def test_it_plays_at_the_speed_that_is_chosen_and_pauses(opened: Open) -> None:
    it = opened("bend")
    it.page.locator("#speed").select_option("4")
    it.page.locator("#play").click()
    it.page.clock.run_for(2_000)
    played = it.at_s

    it.page.locator("#play").click()
    it.page.clock.run_for(2_000)

    assert played == pytest.approx(8.0, abs=0.5)
    assert it.at_s == pytest.approx(played, abs=0.2)


def test_pointing_at_a_plot_moves_the_slider_the_robot_and_the_values(opened: Open) -> None:
    it = opened("bend")
    places = it.places
    value = it.page.locator("#plots .legend .value").first
    before = value.inner_text()
    area = it.page.locator("#plots .u-over").first
    area.scroll_into_view_if_needed()
    box = area.bounding_box()
    assert box is not None

    it.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 20)

    assert it.at_s == pytest.approx(it.end_s / 2, abs=0.1)
    assert float(it.page.locator("#slider").input_value()) == pytest.approx(it.at_s, abs=0.1)
    assert it.places != places
    assert value.inner_text() != before


def test_dragging_across_a_plot_shows_a_part_of_the_run_everywhere(opened: Open) -> None:
    it = opened("bend")
    ticks = it.page.locator("#timeline .axis text")
    whole = ticks.all_text_contents()
    area = it.page.locator("#plots .u-over").first
    area.scroll_into_view_if_needed()
    box = area.bounding_box()
    assert box is not None
    at = box["y"] + 20

    it.page.mouse.move(box["x"] + box["width"] * 0.5, at)
    it.page.mouse.down()
    it.page.mouse.move(box["x"] + box["width"] * 0.75, at, steps=4)
    it.page.mouse.up()

    assert float(ticks.first.text_content() or 0) == pytest.approx(it.end_s * 0.5, abs=0.5)
    assert float(ticks.last.text_content() or 0) == pytest.approx(it.end_s * 0.75, abs=1.0)
    it.page.locator("#whole").click()
    assert ticks.all_text_contents() == whole
    assert it.page.locator("#whole").is_hidden()
    assert it.said == []


def test_a_gap_is_a_grey_band_in_the_timeline_and_in_the_plots(opened: Open) -> None:
    it = opened("gap")
    it.page.clock.run_for(1_000)
    band = it.page.locator("#timeline .gap")
    begin, end = re.findall(r"([\d.]+) s\b", band.locator("title").text_content() or "")

    assert 0.5 < float(end) - float(begin) < 3.0
    assert "nothing is known" in it.page.locator("#key").inner_text()
    inside, outside = (
        it.page.evaluate(PIXEL, at_s) for at_s in (0.6 * float(end) + 0.4 * float(begin), 1.0)
    )
    assert inside[3] > 0
    assert outside[3] == 0


def test_a_click_on_the_timeline_moves_the_slider(opened: Open) -> None:
    it = opened("bend")
    command = it.page.locator("#timeline .span.done", has_text="BendBack")
    command.scroll_into_view_if_needed()

    command.click()

    begin, end = re.findall(r"([\d.]+) s\b", command.locator("title").text_content() or "")[-2:]
    assert it.at_s == pytest.approx((float(begin) + float(end)) / 2, abs=0.3)
    assert "BendBack" in it.page.locator("#now").inner_text()


def test_a_sentence_and_a_phase_of_the_diagram_lead_to_their_time(opened: Open) -> None:
    it = opened("bend")
    sentence = it.page.locator(".story button").nth(4)
    sentence.click()
    assert it.at_s == pytest.approx(float(sentence.inner_text().removesuffix(" s")), abs=0.01)

    node = it.page.locator('#diagram [data-node="halt"]')
    node.focus()
    node.press("Enter")
    assert it.end_s - 1.0 < it.at_s < it.end_s  # it is the last phase and only brakes
    assert "now" in (node.get_attribute("class") or "")


def test_a_failed_run_opens_at_its_failure_and_shows_it_without_scrolling(opened: Open) -> None:
    it = opened("dead")
    cause = it.page.locator(".cause")
    box = cause.bounding_box()

    assert box is not None
    assert box["y"] + box["height"] < 800
    told_s = float(cause.get_by_role("button").inner_text().removesuffix(" s"))
    assert it.at_s == pytest.approx(told_s, abs=0.011)
    assert "driven: " in it.page.locator("#pose").inner_text()
    assert "driven: none" not in it.page.locator("#pose").inner_text()
    assert 0 < it.at_s < it.end_s
    assert "robot.stuck" in it.page.locator(".strip [aria-current]").inner_text()
    it.page.locator("#slider").fill("0")
    cause.get_by_role("button").click()
    assert it.at_s > 0


@pytest.mark.parametrize("name", ["bend", "dead"])
def test_nothing_scrolls_within_the_page(opened: Open, name: str) -> None:
    inner = """[...document.querySelectorAll('main *')].filter((each) =>
        ['auto', 'scroll'].includes(getComputedStyle(each).overflowY)
        && each.scrollHeight > each.clientHeight + 1).map((each) => each.className || each.id)"""

    assert opened(name).page.evaluate(inner) == []


def test_a_picture_of_the_strip_leads_to_its_time(opened: Open) -> None:
    it = opened("bend")
    pictures = it.page.locator(".strip li")
    moments = [
        float(text.removesuffix(" s")) for text in pictures.locator("time").all_inner_texts()
    ]
    it.page.locator("#slider").fill("0")
    places = it.places

    assert "start" in it.page.locator(".strip [aria-current]").inner_text()
    pictures.nth(5).get_by_role("button").click()

    assert moments == sorted(moments)
    assert it.at_s == pytest.approx(moments[5], abs=0.01)
    assert it.places != places
    assert pictures.nth(5).get_attribute("aria-current") == "step"


def test_a_curve_can_be_hidden_and_shown(opened: Open) -> None:
    it = opened("bend")
    curve = it.page.locator("#plots .legend button").first
    canvas = "document.querySelector('#plots canvas').toDataURL()"
    it.page.clock.run_for(100)
    before = it.page.evaluate(canvas)

    curve.click()
    it.page.mouse.move(0, 0)
    it.page.clock.run_for(100)
    hidden = it.page.evaluate(canvas)
    curve.click()

    assert curve.get_attribute("aria-pressed") == "true"
    assert hidden != before


def test_bands_are_behind_the_curves_that_have_one_and_go_with_them(opened: Open) -> None:
    it = opened("expected")
    figure = it.page.locator("#plots figure").first
    canvas = "document.querySelector('#plots canvas').toDataURL()"

    def picture() -> str:
        it.page.clock.run_for(100)
        return str(it.page.evaluate(canvas))

    assert "shaded: 90 % of 40 runs on sim" in figure.locator(".legend .band").inner_text()
    label = figure.locator("[role=img]").get_attribute("aria-label") or ""
    assert label.endswith("shaded: 90 % of 40 runs on sim, each moment by itself")
    whole, curves = picture(), figure.locator(".legend button")
    curves.first.hover()
    alone = picture()
    it.page.mouse.move(0, 0)
    assert picture() == whole != alone
    for each in curves.all():
        each.click()
    it.page.mouse.move(0, 0)
    hidden = picture()
    assert hidden != whole
    assert it.said == []
    assert opened("dead").page.locator("#plots .legend .band").count() == 0


@pytest.mark.parametrize(("wide", "high"), [(1280, 800), (390, 844)])
@pytest.mark.parametrize("name", ["bend", "trace", "expected"])
def test_nothing_is_cut_off_at_the_side(opened: Open, name: str, wide: int, high: int) -> None:
    it = opened(name, wide=wide, high=high)

    assert it.page.evaluate("document.documentElement.scrollWidth") == wide
    assert it.page.locator(".outcome").is_visible()
    assert it.page.locator("#play").is_visible()


def test_by_night_the_page_is_dark(opened: Open) -> None:
    ground = "getComputedStyle(document.body).backgroundColor"

    assert opened("bend").page.evaluate(ground) == "rgb(244, 246, 248)"
    assert opened("bend", scheme="dark").page.evaluate(ground) == "rgb(13, 17, 23)"


def test_the_robot_is_drawn_anew_when_the_night_comes(opened: Open) -> None:
    it = opened("bend")
    day = it.picture

    it.page.emulate_media(color_scheme="dark")
    changed = "day => document.getElementById('scene').toDataURL() !== day"
    it.page.wait_for_function(changed, arg=day)

    assert it.said == []


def test_keys_show_less_or_more_of_the_run(opened: Open) -> None:
    it = opened("bend")
    at_s, presses = 12.0, 3
    whole = it.page.locator("#timeline .tick").count()
    marks = it.page.locator("#timeline .axis text")
    before = marks.all_text_contents()
    it.page.locator("#slider").fill(str(at_s))
    it.page.evaluate("document.activeElement.blur()")

    for _ in range(presses):
        it.page.keyboard.press("+")
    near = marks.all_text_contents()
    it.page.keyboard.press("0")

    assert near != before
    part = 0.5**presses  # the moment shown keeps its place on the screen
    first_s, last_s = at_s - part * at_s, at_s + part * (it.end_s - at_s)
    assert near
    assert all(first_s <= float(each) <= last_s for each in near)
    assert marks.all_text_contents() == before
    assert whole == it.page.locator("#timeline .tick").count()


def test_a_plot_is_put_in_words_for_those_who_do_not_see_it(opened: Open) -> None:
    it = opened("bend")
    labels = [
        each.get_attribute("aria-label") or ""
        for each in it.page.locator("#plots figure [role=img]").all()
    ]
    assert len(labels) == it.page.locator("#plots figure").count()
    assert labels[0].startswith("Joint angles in ° over time: gamma_1 from -")


def test_a_reader_who_wants_less_motion_sees_one_picture_after_another(opened: Open) -> None:
    it = opened("bend")
    it.page.emulate_media(reduced_motion="reduce")
    it.page.locator("#play").click()
    seen = set()
    for _ in range(30):
        it.page.clock.run_for(100)
        seen.add(it.at_s)

    assert 2 <= len(seen) <= 5


@pytest.mark.parametrize("name", ["bend", "dead", "house"])
def test_it_is_printed_on_white_without_what_is_of_no_use_on_paper(opened: Open, name: str) -> None:
    it = opened(name, scheme="dark")
    it.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    it.page.emulate_media(media="print", color_scheme="dark")

    assert it.page.locator(".player").is_hidden()
    assert all(each.is_hidden() for each in it.page.locator(".how").all())
    assert it.page.locator("#moment").inner_text() == f" ({it.page.locator('#clock').inner_text()})"
    ink, paper = it.page.evaluate(
        "['--ink', '--paper'].map((it) => getComputedStyle(document.documentElement)"
        ".getPropertyValue(it).trim())"
    )
    assert (ink, paper) == (DAY["ink"], DAY["paper"])
    wide = it.page.evaluate("document.body.getBoundingClientRect().width")
    widest = it.page.evaluate(
        "Math.max(...[...document.querySelectorAll('main *')]"
        ".map((each) => each.getBoundingClientRect().right))"
    )
    assert wide == pytest.approx(186 / 25.4 * 96, abs=1.0)
    assert widest <= wide + 1.0


RENDERED = """
() => {
  const parse = (text) => (text.match(/[0-9.]+/g) || []).map(Number);
  const two = (v) => Math.round(v).toString(16).padStart(2, '0');
  const hex = ([r, g, b]) => '#' + [r, g, b].map(two).join('');
  const behind = (node) => {
    for (let it = node; it; it = it.parentElement) {
      const colour = parse(getComputedStyle(it).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return hex(colour);
    }
    return hex([255, 255, 255]);
  };
  const found = new Set();
  for (const node of document.querySelectorAll('body *')) {
    const own = [...node.childNodes].some((each) => each.nodeType === 3 && each.data.trim());
    if (!own || node.closest('svg, script, style, noscript') || !node.checkVisibility()) continue;
    const ink = hex(parse(getComputedStyle(node).color));
    found.add(`${ink} ${behind(node)} ${node.className || node.tagName}`);
  }
  return [...found];
}
"""


@pytest.mark.parametrize("name", ["bend", "dead", "house", "expected"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("wish", ["no-preference", "more"])
def test_every_word_on_the_page_can_be_read(
    opened: Open, name: str, scheme: str, wish: str
) -> None:
    it = opened(name, scheme=scheme)
    it.page.emulate_media(color_scheme=scheme, contrast=wish)  # type: ignore[arg-type]
    found = [each.split(" ", 2) for each in it.page.evaluate(RENDERED)]

    low = [
        f"{what}: {ink} on {paper}"
        for ink, paper, what in found
        if contrast(ink, paper) < (TEXT if wish == "no-preference" else 7.0)
    ]
    assert len(found) > 10
    assert low == []


def test_every_control_is_reached_by_tab_and_shows_that_it_has_the_focus(opened: Open) -> None:
    it = opened("house")
    wanted = it.page.locator(
        "button:enabled:visible, input:visible, select:visible, summary:visible,"
        " [tabindex='0']:visible"
    ).count()
    reached = 0
    for _ in range(wanted + 5):
        it.page.keyboard.press("Tab")
        outline = it.page.evaluate(
            "document.activeElement === document.body ? null :"
            " getComputedStyle(document.activeElement).outlineStyle"
        )
        if outline is None:
            break
        assert outline == "solid"
        reached += 1
    assert reached == wanted

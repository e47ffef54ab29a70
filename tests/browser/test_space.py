"""The picture of a network that can be turned."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from .conftest import Opened

pytestmark = pytest.mark.browser

Open = Callable[..., Opened]

NO_WEBGL = """
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith('webgl') ? null : get.call(this, kind, ...more);
};
"""


def eye(it: Opened) -> tuple[float, ...]:
    """Return azimuth, elevation and distance."""
    return tuple(map(float, (it.page.locator("#space").get_attribute("data-eye") or "").split()))


def drag(it: Opened, across: float, down: float, *, key: str = "") -> None:
    """Drag from the middle of the picture."""
    canvas, mouse = it.page.locator("#space"), it.page.mouse
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if key:
        it.page.keyboard.down(key)
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + across, y + down, steps=3)
    mouse.up()
    if key:
        it.page.keyboard.up(key)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_network_opens_without_a_word_and_asks_for_nothing(opened: Open, scheme: str) -> None:
    it = opened("house", scheme=scheme)
    # Where there is no graphics card the browser's own driver says that it is slow.
    assert [said for said in it.said if "GL Driver Message" not in said] == []
    assert len(it.asked) == 1
    assert eye(it)


def test_the_slider_moves_the_robot_in_every_picture(opened: Open) -> None:
    it = opened("house")

    def places() -> list[str | None]:
        pictures = ("#scene", "#scene-side", "#space")
        return [it.page.locator(name).get_attribute("data-places") for name in pictures]

    before = places()
    assert len(set(before)) == 1
    it.page.locator("#slider").fill("9")
    assert len(set(places())) == 1
    assert places() != before


def test_dragging_turns_it(opened: Open) -> None:
    it = opened("house")
    canvas = it.page.locator("#space")
    (azimuth, elevation, distance), picture = eye(it), canvas.screenshot()
    drag(it, 100, 50)
    turned = eye(it)
    assert turned[0] == pytest.approx(azimuth - 0.8, abs=0.01)
    assert turned[1] == pytest.approx(elevation + 0.4, abs=0.01)
    assert turned[2] == distance
    assert canvas.screenshot() != picture


def test_dragging_with_shift_moves_it_and_does_not_turn_it(opened: Open) -> None:
    it = opened("house")
    canvas = it.page.locator("#space")
    before, picture = eye(it), canvas.screenshot()
    drag(it, 100, 50, key="Shift")
    assert eye(it) == before
    assert canvas.screenshot() != picture


def test_the_mouse_wheel_zooms_once_the_picture_has_been_clicked(opened: Open) -> None:
    it = opened("house")
    canvas = it.page.locator("#space")
    canvas.hover()
    before = eye(it)
    it.page.mouse.wheel(0, 300)
    assert eye(it) == before
    canvas.click()
    it.page.mouse.wheel(0, -300)
    it.page.wait_for_function(
        "before => document.getElementById('space').dataset.eye.split(' ')[2] < before",
        arg=before[2],
    )


def test_keys_turn_and_zoom_and_leave_the_time_alone(opened: Open) -> None:
    it = opened("house")
    canvas, at_s = it.page.locator("#space"), it.at_s
    before = eye(it)
    canvas.focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        canvas.press(key)
    azimuth, elevation, distance = eye(it)
    assert azimuth > before[0]
    assert elevation > before[1]
    assert distance < before[2]
    assert it.at_s == at_s


def test_it_follows_the_robot_and_shows_everything_again(opened: Open) -> None:
    it = opened("house")
    before = eye(it)
    follow = it.page.locator("#space-follow")
    follow.click()
    assert follow.get_attribute("aria-pressed") == "true"
    assert eye(it)[2] < before[2]
    it.page.locator("#space-whole").click()
    assert follow.get_attribute("aria-pressed") == "false"
    assert eye(it) == before


def test_a_browser_without_webgl_is_told_so_and_shows_the_rest(opened: Open) -> None:
    it = opened("house", before=NO_WEBGL)
    assert it.said == []
    assert it.page.locator("#space-off").is_visible()
    assert not it.page.locator("#space").is_visible()
    places = it.places
    it.page.locator("#slider").fill("9")
    assert it.places != places


@pytest.mark.parametrize("wide", [360, 1280])
def test_a_network_fits_its_page(opened: Open, wide: int) -> None:
    it = opened("house", wide=wide)
    assert it.page.evaluate("document.documentElement.scrollWidth") <= wide

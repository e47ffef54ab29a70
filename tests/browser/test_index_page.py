from __future__ import annotations

from collections.abc import Callable

import pytest

from .conftest import LIST, Opened

pytestmark = pytest.mark.browser

Open = Callable[..., Opened]


def column(it: Opened, name: str) -> list[str]:
    """The cells of a column, of the rows that can be seen."""
    return it.page.locator(f'tbody tr:not([hidden]) td[data-name="{name}"]').all_text_contents()


def seconds(texts: list[str]) -> list[float]:
    return [float(text.removesuffix(" s")) for text in texts]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(
    ("wide", "high"), [(1280, 800), (1181, 800), (1024, 768), (901, 700), (390, 844)]
)
def test_a_list_opens_without_a_word_and_nothing_is_cut_off(
    opened: Open, scheme: str, wide: int, high: int
) -> None:
    it = opened(LIST, scheme=scheme, wide=wide, high=high)

    assert it.said == []
    assert len(it.asked) == 1
    assert it.page.evaluate("document.documentElement.scrollWidth") == wide


def test_a_click_on_a_column_sorts_by_it_and_another_one_turns_it_round(opened: Open) -> None:
    it = opened(LIST)
    duration = it.page.get_by_role("columnheader", name="Duration")
    assert column(it, "Began") == sorted(column(it, "Began"), reverse=True)

    duration.get_by_role("button").click()
    rising = seconds(column(it, "Duration"))
    assert duration.get_attribute("aria-sort") == "ascending"
    duration.get_by_role("button").click()

    assert rising == sorted(rising)
    assert seconds(column(it, "Duration")) == rising[::-1]
    assert duration.get_attribute("aria-sort") == "descending"


@pytest.mark.parametrize("wide", [1280, 390])
def test_a_click_on_an_outcome_leaves_only_the_runs_that_ended_so(opened: Open, wide: int) -> None:
    it = opened(LIST, wide=wide)
    every = len(column(it, "Mission"))
    failed = it.page.locator('[data-outcome="failed"]')

    failed.click()
    left = it.page.locator("tbody tr:visible")

    assert 0 < left.count() < every
    assert all("Failed" in text for text in left.all_text_contents())
    failed.click()
    assert len(column(it, "Mission")) == every


def test_a_run_leads_to_its_report(opened: Open) -> None:
    it = opened(LIST)

    it.page.get_by_role("link", name="patrol").click()

    it.page.wait_for_selector("html[data-ready=yes] #slider", state="attached")
    assert it.page.title() == "patrol: Succeeded"

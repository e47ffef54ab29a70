"""What the check of a built site finds."""

from __future__ import annotations

from pathlib import Path

import pytest

from website.built_site import faults, main

NEAR = {
    "404.html": '<script src="//cdn.example/x.js"></script>',
    "tutorial/index.html": '<a href="one.html">1</a> <a href="https://example.org">out</a>',
    "tutorial/one.html": '<a href="../two.html#part">2</a>',
    "two.html": '<img src="a.png"><a href="tutorial/index.html">back</a>',
}


def built(folder: Path, **pages: str) -> Path:
    for name, text in (NEAR | pages).items():
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder


def test_the_page_for_missing_ones_is_looked_at_too(tmp_path: Path) -> None:
    assert list(faults(built(tmp_path))) == ["404.html: fetches //cdn.example/x.js"]


@pytest.mark.parametrize(
    "element",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="https://fonts.example/x.css">',
        '<img src="//images.example/x.png">',
        '<iframe src="http://pages.example"></iframe>',
    ],
)
def test_what_is_fetched_from_elsewhere_is_found(tmp_path: Path, element: str) -> None:
    found = list(faults(built(tmp_path, **{"404.html": "", "two.html": element})))

    assert len(found) == 1
    assert found[0].startswith("two.html: fetches ")


@pytest.mark.parametrize("rule", ["@import 'https://x.example/y.css';", "a{b:url(//x.example/y)}"])
def test_styles_that_fetch_are_found(tmp_path: Path, rule: str) -> None:
    site = built(tmp_path, **{"404.html": ""})
    (site / "site.css").write_text(rule, encoding="utf-8")

    assert [each.partition(":")[0] for each in faults(site)] == ["site.css"]


def test_a_link_that_leads_nowhere_is_found(tmp_path: Path) -> None:
    pages = {"404.html": "", "two.html": '<a href="three.html">3</a>'}

    assert list(faults(built(tmp_path, **pages))) == [
        "two.html: leads to three.html, which is not there"
    ]


def test_a_page_that_is_too_far_away_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chain = {f"{n}.html": f'<a href="{n + 1}.html">on</a>' for n in range(3, 6)} | {"6.html": ""}
    site = built(tmp_path, **{"404.html": "", "two.html": '<a href="3.html">on</a>'}, **chain)

    assert list(faults(site)) == [
        f"{n}.html: more than 3 clicks from the tutorial" for n in (4, 5, 6)
    ]
    assert main(str(site)) == 1
    assert capsys.readouterr().out.count("\n") == 3

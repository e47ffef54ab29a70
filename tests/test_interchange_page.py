"""The page on interchange: its commands and its Python do what it says, in its order."""

from __future__ import annotations

import re

import pytest
from followed_page import BLOCK
from page_reader import ROOT, Reader, reader

__all__ = ["reader"]

PAGE = ROOT / "docs" / "interchange.md"

WRONG = """\
<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" name="door">
  <parallel id="doors">
    <state id="Door">
      <history id="last"/>
      <state id="Open"/>
      <state id="Shut"><transition event="Close" target="Open" cond="!In('Opn')"/></state>
    </state>
  </parallel>
</scxml>
"""


@pytest.mark.thorough
def test_the_page_does_what_it_says(reader: Reader) -> None:
    (reader.folder / "wrong.scxml").write_text(WRONG, encoding="utf-8")
    printed, ran = "", {"sh": 0, "text": 0, "python": 0}
    for _, kind, code in BLOCK.findall(PAGE.read_text("utf-8")):
        ran[kind] += 1
        if kind == "python":
            exec(compile(code, str(PAGE), "exec"), {})
        elif kind == "sh":
            printed = ""
            for line in code.splitlines():
                command, _, exits = line.partition(" # exit ")
                exited, shown = reader.run(command)
                assert exited == int(exits or 0), f"{command}\n{shown}"
                printed += shown
        else:
            lines = {re.sub(r"\s+", " ", each).strip() for each in printed.splitlines()}
            assert lines.issuperset(code.splitlines()), printed
    assert ran == {"sh": 6, "text": 2, "python": 3}

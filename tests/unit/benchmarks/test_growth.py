"""What the program does grows linearly with what it is given, by the number of calls it takes."""

from __future__ import annotations

import sys
from math import log2
from pathlib import Path

import pytest

from benchmarks.growth import ROWS, Work


def calls_in(work: Work) -> int:
    """How many functions are called, of Python and of C."""
    count = 0

    def counted(_frame: object, event: str, _of: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough) if name == "recording" else name
        for name in ROWS
    ],
)
def test_calls_grow_as_the_row_says(name: str, tmp_path: Path) -> None:
    row = ROWS[name]
    row.made(tmp_path, row.counted)()  # caches are filled

    one, two, four = (calls_in(row.made(tmp_path, row.counted * times)) for times in (1, 2, 4))

    assert one < two
    assert log2((four - two) / (two - one)) <= row.bar  # of what is added: a part is always there

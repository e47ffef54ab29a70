"""Sheets have their true size, and the tags on them are read again."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.targets import Chessboard, board_sheet, find_tags, tag_sheets

SVG = "{http://www.w3.org/2000/svg}"
PX_PER_MM = 4


def printed(sheet: str) -> np.ndarray:
    """The black and white squares of a sheet, as a printer would make them."""
    root = ElementTree.fromstring(sheet)
    width, height = (float(root.attrib[key].removesuffix("mm")) for key in ("width", "height"))
    page = np.full((round(height * PX_PER_MM), round(width * PX_PER_MM)), 255, np.uint8)
    for rect in root.iter(f"{SVG}rect"):
        x, y = float(rect.get("x", 0)), float(rect.get("y", 0))
        ends = (x, y, x + float(rect.attrib["width"]), y + float(rect.attrib["height"]))
        left, top, right, bottom = (round(each * PX_PER_MM) for each in ends)
        page[top:bottom, left:right] = 255 if rect.get("fill") == "white" else 0
    return page


@pytest.mark.parametrize("family", ["aruco_4x4_50", "apriltag_36h11"])
def test_printed_tags_are_read_again_with_their_size(family) -> None:
    tags = [(str(number), f"<module {number}>") for number in range(5)]
    (sheet,) = tag_sheets(family, 0.04, tags)
    found = find_tags(printed(sheet), family)

    assert [tag.number for tag in found] == [0, 1, 2, 3, 4]
    sides = [np.linalg.norm(tag.corners[0] - tag.corners[1]) / PX_PER_MM for tag in found]
    assert sides == pytest.approx([40.0] * 5, abs=0.4)
    assert "3 &lt;module 3&gt;" in sheet


def test_tags_that_do_not_fit_go_to_another_sheet() -> None:
    sheets = list(tag_sheets("aruco_4x4_50", 0.04, [(str(n), "") for n in range(12)]))

    counts = [len(find_tags(printed(sheet), "aruco_4x4_50")) for sheet in sheets]
    assert len(counts) > 1
    assert sum(counts) == 12


def test_the_board_has_its_squares_and_a_ruler_of_100_mm() -> None:
    sheet = board_sheet(Chessboard((9, 6), 0.025))
    found, corners = cv2.findChessboardCornersSB(printed(sheet), (9, 6))

    assert found
    assert np.linalg.norm(corners[0] - corners[8]) / PX_PER_MM == pytest.approx(8 * 25, abs=0.3)
    assert 'width="100"' in sheet
    assert sheet.startswith('<svg xmlns="http://www.w3.org/2000/svg" class="sheet" width="297mm"')
    assert 'height="210mm"' in sheet


def test_a_large_board_makes_a_large_sheet() -> None:
    sheet = board_sheet(Chessboard((11, 8), 0.04))

    size = re.search(r'width="([\d.]+)mm" height="([\d.]+)mm"', sheet)
    assert size is not None
    assert float(size[1]) >= 12 * 40
    assert float(size[2]) >= 9 * 40

from __future__ import annotations

import pytest

from pirate_sm.lab.mapping.legs import Bore, diameter_of, narrowings

SPAN_M = 0.11


def driven(to_m: float, *, cone: tuple[float, float], before: float, behind: float) -> list[Bore]:
    """What a V shows on its way through a cone: the mean of its wheels' diameters."""

    def wall(at_m: float) -> float:
        begins_m, ends_m = cone
        share = min(max((at_m - begins_m) / (ends_m - begins_m), 0.0), 1.0)
        return before + share * (behind - before)

    found = []
    for step in range(round(to_m / 0.002)):
        rear_m = step * 0.002
        outer = (wall(rear_m) + wall(rear_m + SPAN_M)) / 2
        shown = (outer + wall(rear_m + SPAN_M / 2)) / 2
        found.append(Bore(rear_m, rear_m + SPAN_M, shown))
    return found


@pytest.mark.parametrize("cone", [(0.5, 0.56), (0.5, 0.501), (0.4, 0.5)])
@pytest.mark.parametrize(("before", "behind"), [(0.12, 0.105), (0.11, 0.12)])
def test_the_middle_of_a_reducer_is_found(
    cone: tuple[float, float], before: float, behind: float
) -> None:
    (found,) = narrowings(driven(0.9, cone=cone, before=before, behind=behind))
    assert found.middle_m == pytest.approx(sum(cone) / 2, abs=0.025)
    assert found.diameter_m == pytest.approx(behind, abs=0.001)


def test_noise_is_no_reducer() -> None:
    bores = driven(0.9, cone=(0.5, 0.56), before=0.12, behind=0.1215)
    assert list(narrowings(bores)) == []
    assert diameter_of(bores) == pytest.approx(0.12, abs=0.0015)


def test_nothing_shown_is_nothing_known() -> None:
    assert diameter_of([]) is None
    assert list(narrowings([])) == []

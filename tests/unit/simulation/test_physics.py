from __future__ import annotations

from pirate_sm.simulation.physics import PER_WHEEL, SINGLE, QuantityLayout


def test_every_quantity_has_a_place_of_its_own() -> None:
    layout = QuantityLayout(4)
    places = [layout.at(name, wheel) for name in PER_WHEEL for wheel in range(4)]
    places += [layout.at(name) for name in SINGLE]
    assert sorted(places) == list(range(layout.size))


def test_the_values_of_all_wheels_stand_side_by_side() -> None:
    layout = QuantityLayout(4)
    block = layout.block("arc")
    assert [*range(block.start, block.stop)] == [layout.at("arc", wheel) for wheel in range(4)]

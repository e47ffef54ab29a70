"""A few of the configurations in which `make physics` tries the properties of MuJoCo's world."""

from __future__ import annotations

import pytest

from benchmarks.physics_properties import PROPERTIES, Property, misses
from pirate_sm.simulation.physics import ChainBody


@pytest.mark.parametrize("it", PROPERTIES, ids=lambda it: it.miss.__name__)
def test_a_property_holds_in_random_configurations(it: Property, chain: ChainBody) -> None:
    found = misses(it, chain, share=0.04, seed=1)

    assert {where: by for where, by in found.items() if by > it.most} == {}

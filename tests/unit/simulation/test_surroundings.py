from __future__ import annotations

import numpy as np
import pytest

from pirate_sm.core._model.pipe import Blockage, Start
from pirate_sm.core._model.pipe_runs import Mitre
from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Friction, Pipe, Profile, Straight
from pirate_sm.simulation.physics import ChainBody
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter, Surroundings, surroundings_of

PIPE = Pipe(diameter=0.12, segments=(Straight(straight=3.0),), start=Start(at=1.5))


def drawn(profile: Profile, chain: ChainBody, jitter: Jitter, pipe: Pipe = PIPE) -> Surroundings:
    rng = np.random.default_rng(3)
    return surroundings_of(profile, chain, pipe, duties={}, jitter=jitter, rng=rng)


def test_without_jitter_the_numbers_are_those_of_the_files(
    profile: Profile, chain: ChainBody
) -> None:
    around = drawn(profile, chain, NO_JITTER)
    assert around.pose.places[0] == pytest.approx((1.5, 0.0, 0.0))
    assert around.friction == profile.simulation.friction
    assert around.route.pieces[0].diameter_m == 0.12


def test_jitter_stays_within_its_bounds(profile: Profile, chain: ChainBody) -> None:
    around = drawn(profile, chain, Jitter(0.02, 0.2, 0.002))
    shares = (
        (around.pose.places[0][0] - 1.5) / 0.02,
        (around.friction.static / profile.simulation.friction.static - 1.0) / 0.2,
        (around.route.pieces[0].diameter_m - 0.12) / 0.002,
    )
    assert all(0.0 < abs(share) < 1.0 for share in shares)
    assert len(set(shares)) == 3


def test_the_friction_and_blockages_of_the_pipe_are_taken(
    profile: Profile, chain: ChainBody
) -> None:
    own = Friction(static=0.3, kinetic=0.2)
    blocked = (Blockage(at=2.0, lasting=5.0),)
    around = drawn(
        profile, chain, NO_JITTER, PIPE.model_copy(update={"friction": own, "blockages": blocked})
    )
    assert around.friction == own
    assert [(each.arc_m, each.lasting_s) for each in around.obstacles] == [(2.0, 5.0)]


def test_a_pipe_that_its_own_diameter_makes_impossible_is_refused(
    profile: Profile, chain: ChainBody
) -> None:
    parts = (Straight(straight=0.05), Mitre(mitre=1.5), Straight(straight=1.0))
    pipe = PIPE.model_copy(update={"segments": parts})
    with pytest.raises(UsageError, match="straight 1 is 50 mm long"):
        drawn(profile, chain, NO_JITTER, pipe)

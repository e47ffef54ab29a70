from __future__ import annotations

from pirate_sm.core.models import Profile
from pirate_sm.simulation.physics import chain_of


def test_hold_torque_and_dead_drag_are_those_of_the_profile(profile: Profile) -> None:
    torques = {"hold_torque": 0.123, "dead_drag": 0.045}
    motors = {**profile.motors, "wheel": profile.motors["wheel"].model_copy(update=torques)}
    wheels = chain_of(profile.model_copy(update={"motors": motors})).wheels
    assert {(wheel.hold_nm, wheel.dead_drag_nm) for wheel in wheels} == {(0.123, 0.045)}

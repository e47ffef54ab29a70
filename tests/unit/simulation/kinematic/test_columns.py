"""Columns of the two kernels, some of whose functions are the same."""

from __future__ import annotations

from pirate_sm.simulation.kinematic import columns as plane
from pirate_sm.simulation.kinematic.space import columns as space

OF_JOINTS_AND_MOTORS = ("J_", "JOINT_", "WHEEL_", "LINK_", "T_")


def test_columns_of_functions_that_both_kernels_use_are_the_same() -> None:
    shared = [name for name in vars(plane) if name.startswith(OF_JOINTS_AND_MOTORS)]
    shared = [name for name in shared if name != "T_INV"]
    shared += ["DT", "RADIUS", "MASS_INV", "SPIN", "FORCE", "SLOPE", "NODE", "PUSH"]

    assert {name: getattr(plane, name) for name in shared} == {
        name: getattr(space, name) for name in shared
    }
    assert plane.KEY == space.SURFACE

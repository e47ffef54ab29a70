"""The protocol of a physics that lets cycles pass in one compiled call."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from pirate_sm.simulation.arrays import Floats


@runtime_checkable
class GlidingPhysics(Protocol):
    """A physics with two compiled functions around its step.

    One calls :func:`~pirate_sm.simulation.gliding.cycle.may_begin` before the step and
    :func:`~pirate_sm.simulation.gliding.cycle.goes_on` after it, as long as both return true; the
    other :func:`~pirate_sm.simulation.gliding.cycle.may_pass` and
    :func:`~pirate_sm.simulation.gliding.cycle.passes_on`. They are all that a physics adds; see
    :mod:`pirate_sm.simulation.xpbd.glide`.
    """

    @property
    def roll_angles(self) -> Floats:
        """Angle of the roll joint, then the roll of the parts ahead and behind, rad.

        This is one array as long as the physics exists.
        """

    def glide(self, *groups: Any) -> None:
        """Let cycles pass; the arguments are those of ``xpbd.glide.glide`` from ``place`` on."""

    def pass_cycles(self, *groups: Any) -> None:
        """Let cycles pass with the duties in force; as for ``xpbd.glide.pass_cycles``."""

"""The names of how finely the kinematic simulator computes."""

from __future__ import annotations

from typing import Literal, TypeAlias

Fidelity: TypeAlias = Literal["usual", "fast"]
"""``fast`` computes half the iterations and is coarser, with an error that has been measured."""

USUAL: Fidelity = "usual"

"""Names of the parts of MuJoCo's model, which its text gives and the running world looks up."""

from __future__ import annotations

LINK, WHEEL, BEND = "link_", "wheel_", "bend_"
"""A link by its number; a wheel, its motor and its site; the joint at a wheel and its spring."""
ROLL, ROLL_REAR = "roll", "roll_rear"
X_DRAG, Y_DRAG = "x_drag_", "y_drag_"
"""The friction of a wheel that lies on the floor, along and across its link."""
OBSTACLE = "obstacle"

WHEEL_BIT, LINK_BIT, BOTH_BITS = "1", "2", "3"
"""What touches what: walls touch both, an obstacle touches wheels."""


def numbers(*values: float) -> str:
    """Return numbers as the model's text has them."""
    return " ".join(f"{value:.12g}" for value in values)

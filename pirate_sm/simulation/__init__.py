"""A simulated robot: its electronics and surroundings, over any physics that moves its chain."""

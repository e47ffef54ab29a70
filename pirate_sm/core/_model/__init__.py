"""Frozen data that all other parts share: robot profile, mission, pipe, events, effects."""

"""Frozen data that everything else speaks in: robot profile, mission, pipe, events, effects."""

"""Frozen data that all layers share: robot profile, mission, pipe, events, effects."""

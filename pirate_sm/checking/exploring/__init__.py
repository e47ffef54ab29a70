"""Explore everything that can happen to a mission, by running the engine with all choices."""

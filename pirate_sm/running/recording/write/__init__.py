"""Writes a recording while the mission runs, and shows the run to connected viewers."""

"""Writes a recording while the mission runs, and shows the run to viewers that are connected."""

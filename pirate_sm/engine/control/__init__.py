"""Setpoints of a stage, and the loops that bring joints to their angles."""

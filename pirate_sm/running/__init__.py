"""Runs of a mission: the loop, what it is wired of, its recording."""

"""Answers shells that complete a command line: which values fit here, with a line about each."""

ASKING = "PIRATE_SM_COMPLETE"
"""Environment variable of a shell that asks what fits on a command line, without arguments."""

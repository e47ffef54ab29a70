"""Answers shells that complete a command line: which values fit here, with a line about each."""

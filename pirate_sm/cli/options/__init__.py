"""The options of each command, and how their values are read; importing them is quick."""

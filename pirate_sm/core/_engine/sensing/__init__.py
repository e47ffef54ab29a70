"""Convert raw values to SI signals, judge their plausibility, derive the pipe around the robot."""

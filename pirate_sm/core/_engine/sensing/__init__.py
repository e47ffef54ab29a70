"""Convert raw values to SI signals, judge whether they can be, derive the pipe around the robot."""

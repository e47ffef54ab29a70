"""Make SI signals of raw values, decide which to believe, derive the pipe around the robot."""

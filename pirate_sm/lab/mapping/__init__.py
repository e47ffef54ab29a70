"""Maps the pipe that a robot has driven through, from its signals and words alone."""

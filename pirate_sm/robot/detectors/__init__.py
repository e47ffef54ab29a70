"""Detectors report where the robot is: the simulator, odometry, a person, another program."""

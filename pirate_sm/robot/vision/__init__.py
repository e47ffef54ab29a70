"""Cameras: their pictures, lens and place, and what is seen of the robot; alone imports OpenCV."""

# First, so that whatever is imported from here says the same where OpenCV is not installed.
from pirate_sm.robot.vision import opencv as opencv

"""Cameras: their pictures, lens and place, and what is seen of the robot; alone imports OpenCV."""

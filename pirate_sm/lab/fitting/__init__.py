"""Fits curves of slip, and the numbers of a simulated robot, to what was recorded."""

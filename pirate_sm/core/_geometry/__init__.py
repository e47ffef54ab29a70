"""Pipes as networks in space, routes through them, robot kinematics and clamp statics.

All functions are pure arithmetic on SI values, without files, clocks or file models.
"""

"""Pipes as networks in space, routes through them, the chain of a robot and the forces of a clamp.

Everything here is plain arithmetic on SI values: no file, no clock, no model of a file.
"""

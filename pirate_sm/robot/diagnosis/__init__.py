"""Examine a connected robot: what it reports, what is missing, whether it may be used.

It uses the driver's parts on any port, so an emulated robot in virtual time can replace a real one.
It prints nothing.
"""

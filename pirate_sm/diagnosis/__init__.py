"""Examine a connected robot: what it reports, what is missing, whether it may be used.

Written against the driver's parts and any port, so that an emulated robot in virtual time can
stand in for a real one. Prints nothing.
"""

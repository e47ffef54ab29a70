"""An emulated bay: the device end of a robot's serial link, with a simulated robot behind it.

All modules up to :mod:`pirate_sm.simulation.bay.virtual` are pure: the time is an argument, bytes
go in and out. :mod:`pirate_sm.simulation.bay.terminal` serves the bay on a pseudo-terminal in real
time.
"""

"""An emulated bay: the device end of a robot's serial link, with a simulated robot behind it.

Everything up to :mod:`pirate_sm.bay.virtual` is pure: time is an argument, bytes go in and come
out. :mod:`pirate_sm.bay.terminal` puts it behind a pseudo-terminal in real time.
"""

"""What performs the engine's effects: the loop, its clock, who stands beside it, the way out.

Only this package lets time pass and a backend move. :mod:`pirate_sm.runtime.loop` is the door.
"""

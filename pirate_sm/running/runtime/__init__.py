"""Run the engine on a backend: one step, the loop, clocks, companions, the safe stop.

Only this package lets time pass and a backend move. Start at :mod:`pirate_sm.running.runtime.loop`.
"""

"""Missions in YAML for in-pipe inspection robots: checked, simulated and run by one engine.

Importing this package loads nothing else: the command line must answer at once.
"""

__version__ = "0.1.0"

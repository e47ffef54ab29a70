"""The operator's console: a client of the runtime, in the terminal.

Widgets get immutable snapshots and post messages; only the session talks to the run.
"""

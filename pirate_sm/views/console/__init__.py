"""The operator's console: a client of the runtime, in the terminal.

Widgets receive immutable snapshots and post messages; only the session uses the run.
"""

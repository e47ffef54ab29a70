"""Backends take arrays of setpoints and report events: a trace, a simulator, a serial link."""

"""The running mission: its program, its interpreter, pauses, faults, operator requests, its end."""

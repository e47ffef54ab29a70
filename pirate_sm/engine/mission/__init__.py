"""The mission as it runs: its program, pauses, diversions, what the operator asks for, its end."""

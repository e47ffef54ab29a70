"""Commands that lead a robot into states, or back into a phase of a mission."""

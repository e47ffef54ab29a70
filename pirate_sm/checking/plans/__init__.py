"""Find commands that lead a robot to given states, or back into a phase of a mission."""

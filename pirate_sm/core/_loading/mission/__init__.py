"""Load a mission with its robot, its pipe and the missions it calls, as one program."""

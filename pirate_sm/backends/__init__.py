"""What an array of setpoints can be handed to: a tracer, a simulator, later the real robot."""

"""The commanded robot: its chart, its commands, and the criteria that confirm them."""

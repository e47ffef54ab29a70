"""The commanded robot: its chart, its commands with setpoints and loops, and what confirms them."""

"""Rules that find what is wrong with a robot and its chart."""

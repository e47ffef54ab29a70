"""A graph as one SVG without scripts, fonts or other external resources."""

"""A graph as one SVG: no script, no font and no picture from elsewhere."""

"""A kinematic simulator of a chain of wheels and links in a pipe of straights and mitre bends."""

"""Compare the possible behaviour of two versions of a mission."""

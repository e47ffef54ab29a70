"""Reports of checks, for people and for programs."""

"""Rules that find what is wrong with a mission, and how they are run."""

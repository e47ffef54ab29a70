"""Rules for checking missions, and the check that runs them."""

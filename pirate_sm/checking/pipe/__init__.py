"""Rules for checking missions in their pipes."""

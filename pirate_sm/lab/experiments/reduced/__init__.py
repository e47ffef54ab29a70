"""The reduced physics: a clamped robot as one mass with wheels on a line (thesis 3-4-2)."""

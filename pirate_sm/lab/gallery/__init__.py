"""Scenes that show what the program does: their files, what came of them, their pages."""

"""A backend and a detector of another package."""

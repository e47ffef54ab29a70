"""Reads recordings, complete or cut short, and repairs them."""

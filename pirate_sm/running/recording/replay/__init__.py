"""Replays recordings and compares the result, or one run with another."""

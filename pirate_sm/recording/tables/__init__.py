"""Recordings as CSV files."""

"""Executes the recorded inputs again and compares the result, or one run with another."""

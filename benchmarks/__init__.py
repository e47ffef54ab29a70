"""Measurements behind the numbers in the docs; none of them is part of the tests."""

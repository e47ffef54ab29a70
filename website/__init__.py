"""The documentation site: its hooks, the pages that are made of the program, and its pictures."""

"""A robot as a page of tables and drawings."""

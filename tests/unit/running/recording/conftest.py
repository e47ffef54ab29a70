"""Makes the helpers beside this file importable for the tests in the folders below it."""

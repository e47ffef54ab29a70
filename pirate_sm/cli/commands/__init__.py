"""The work of each command after its options are read: those that are alike share a module."""

"""The work of each command after its options are read, in a module of its name."""

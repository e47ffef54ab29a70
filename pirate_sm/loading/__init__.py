"""Load files into models: every fault of a file is reported at once, with its place."""

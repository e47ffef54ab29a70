"""From files to models: every fault of a file at once, each with its place."""

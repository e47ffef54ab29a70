"""Read YAML files into models: every fault of a file at once, each with line and column."""

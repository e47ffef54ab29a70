"""Read YAML files into models; report all faults of a file at once, with line and column."""

"""Read chart files and explore every configuration that a chart can reach."""

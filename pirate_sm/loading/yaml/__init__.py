"""Read YAML files: plain data with the place of every value, validated against the models."""

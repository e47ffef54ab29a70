"""Read YAML files as plain data with the place of every value, and validate them."""

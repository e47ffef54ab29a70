"""Research: campaigns, learning, fitting, mapping, the experiments of a thesis."""

"""From raw values to signals in SI, which of them can be believed, and the pipe they show."""

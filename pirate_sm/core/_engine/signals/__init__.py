"""What frames make of the signals: a table of operations, and the one evaluator that runs it."""

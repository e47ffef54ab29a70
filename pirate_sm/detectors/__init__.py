"""Who says a detector's words when no simulator knows them: reckoning, a person, a program."""

"""Everything that can happen to a mission: the production engine, walked through every choice."""

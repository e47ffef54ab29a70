"""What a check has found, written for people and for programs."""

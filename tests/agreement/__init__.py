"""What the check says of a mission, held against what happens when it is run."""

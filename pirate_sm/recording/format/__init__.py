"""What a recording file holds: its header, its topics, and states of the engine as text."""

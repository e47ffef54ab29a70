"""The content of a recording file: its header, its topics, and engine states as text."""

"""What must not happen: safety rules, and faults that signals show."""

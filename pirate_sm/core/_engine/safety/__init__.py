"""Safety rules, and faults found in the signals."""

"""Safety rules, faults found in the signals, and the start check against the sensors."""

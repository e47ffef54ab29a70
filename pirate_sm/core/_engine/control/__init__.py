"""Compute the setpoints of a stage and run the control loops of joints and wheels."""

"""What environments of Gymnasium are made of; ``pirate_sm.learning`` registers them."""

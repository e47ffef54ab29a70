"""Rules for checking robots and their charts."""

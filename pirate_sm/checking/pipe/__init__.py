"""Rules that find where a mission does not fit its pipe."""

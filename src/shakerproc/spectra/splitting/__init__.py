"""A long record split into shocks and parts of steady vibration."""

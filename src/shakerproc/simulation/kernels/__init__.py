"""The compiled part: a table of laws, their modes and switchings, and the steppers."""

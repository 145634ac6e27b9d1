"""One run: its curves, figures and numbers, and the tables of all runs."""

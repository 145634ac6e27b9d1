"""Functions that the commands and the public API both call, and their results."""

"""What the commands and the public API both call, and the results that they return."""

"""Which effect would explain the departure, how surely, and which test would settle it."""

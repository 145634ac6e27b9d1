"""A modal analysis: its sections of the page, its figures, its mode shapes."""

"""The evidence of a comparison and of a diagnosis: sections, figures and tables."""

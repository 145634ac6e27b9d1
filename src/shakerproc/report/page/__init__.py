"""The report as one HTML page: sections, header, templates, photo, PDF."""

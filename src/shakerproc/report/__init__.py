"""The only room that draws: figures, tables for people, the report page."""

"""Files of other programs: Nastran decks, punch files, testing machines."""

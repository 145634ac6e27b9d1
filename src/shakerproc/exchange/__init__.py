"""What other programs write and read: Nastran decks, punch files, testing machines."""

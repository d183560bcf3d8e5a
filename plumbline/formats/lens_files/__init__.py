"""Files that describe a lens without picks."""

"""Reading and writing picture files with their metadata."""

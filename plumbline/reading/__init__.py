"""From files and options to observations."""

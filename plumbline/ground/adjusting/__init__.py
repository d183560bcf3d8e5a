"""The adjustment: what is observed, what is unknown, the equations between them, least squares."""

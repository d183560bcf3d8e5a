"""The result of a fit, and the files that hold it."""

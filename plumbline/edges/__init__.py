"""The photograph's own edges: found to a small part of a pixel, between picks or without any."""

"""Lenses in pixels, their derivatives, and straight lines through points."""

"""Photographs as pixels: reading, resampling and writing them."""

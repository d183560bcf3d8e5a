"""Photographs: their EXIF, their pixels and their metadata."""

"""Zoom lenses: calibrations joined over the focal length."""

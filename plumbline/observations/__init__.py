"""What was picked: photos, lines of points, and what is known of their lenses."""

from plumbline.observations.observations import MAX_SIDE, Line, Observations, Origin, Photo

__all__ = ["MAX_SIDE", "Line", "Observations", "Origin", "Photo"]

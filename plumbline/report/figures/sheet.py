"""A figure that shows itself in a notebook, whatever its backend; loaded only to draw."""

from __future__ import annotations

from matplotlib.figure import Figure

from plumbline.report.figures import encoding


class Sheet(Figure):
    """A figure on paper of its own."""

    def _repr_png_(self) -> bytes:
        """What IPython shows."""
        return encoding.png_bytes(self)

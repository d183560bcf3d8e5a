"""The coefficients of a zoom lens over focal length, plotted."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from plumbline._version import __version__
from plumbline.files import MARK, refuse_unknown_suffix
from plumbline.frame import Frame
from plumbline.lenses.zoom.needs import needs
from plumbline.lenses.zoom.zoom_lens import ZoomLens
from plumbline.models import CENTRE

PLOT_SUFFIXES = (".png", ".svg")


def plot_zoom(lens: ZoomLens, target: Path) -> bytes:
    """A picture of the curves, error bars of one standard error, and what is needed most.

    Args:
        lens: The lens.
        target: Its suffix says the format, `.png` or `.svg`.

    Raises:
        WriteError: it is neither.
    """
    refuse_unknown_suffix(target, PLOT_SUFFIXES, "plots")
    suffix = target.suffix.lower()
    from matplotlib.figure import Figure

    shown = [name for name in lens.names if name in lens.free] or list(lens.model.coefficients)
    radius_px = Frame(*lens.size, lens.pixel_aspect).radius_px
    figure = Figure(figsize=(7, 1 + 2.2 * len(shown)), layout="constrained")
    axes = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    focals = np.geomspace(*lens.range_mm, 200)
    curve = np.stack([lens.at(float(f)) for f in focals])
    errors = np.stack([np.sqrt(np.diag(lens.covariance_at(float(f)))) for f in focals])
    needed = needs(lens)[0].focal_mm
    for name, plot in zip(shown, axes, strict=True):
        index = lens.names.index(name)
        scale = radius_px if name in CENTRE else 1.0
        values = np.array([node.values[index] for node in lens.nodes]) * scale
        bars = np.array([node.errors[index] for node in lens.nodes]) * scale
        middle, width = curve[:, index] * scale, errors[:, index] * scale
        plot.fill_between(focals, middle - width, middle + width, color="0.85", linewidth=0)
        plot.plot(focals, middle, color="C0", linewidth=1)
        plot.errorbar(lens.focals_mm, values, bars, fmt="o", color="C0", markersize=4, capsize=3)
        plot.axvline(needed, color="C1", linestyle=":", linewidth=1)
        plot.set_ylabel(f"{name}, px" if name in CENTRE else name)
    axes[-1].set_xlabel("focal length, mm (dotted: another calibration is most needed)")
    axes[0].set_title(f"{lens.model.label}, {lens.method}, ± 1 standard error")
    out = io.BytesIO()
    creator = f"{MARK} {__version__}"
    metadata = {"Software": creator} if suffix == ".png" else {"Creator": creator, "Date": None}
    figure.savefig(out, format=suffix[1:], dpi=120, metadata=metadata)
    return out.getvalue()

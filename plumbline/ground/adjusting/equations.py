"""The observation equations: how far each observation is from what a state says.

Every block holds residuals over their standard errors and the derivative of these by the steps
of the unknowns. The weight of a point is not that of its pick alone: its place on the plane and
its height are unknowns, observed with errors of their own, which is the same as weighting its
pick by (σ_p² I + J Σ_g Jᵀ)⁻¹.
"""

from __future__ import annotations

from plumbline.ground.adjusting import lines, points, told
from plumbline.ground.adjusting.block import Block
from plumbline.ground.adjusting.network import Network
from plumbline.ground.adjusting.state import Layout, State

_BUILDERS = (
    points.picks,
    points.points,
    points.flatness,
    points.tapes,
    points.right_angles,
    points.datum,
    lines.lines,
    lines.horizon,
    lines.straight,
)


def blocks(network: Network, layout: Layout, start: State, state: State) -> list[Block]:
    """All observation equations.

    Args:
        network: What was observed.
        layout: Order of the unknowns.
        start: The state whose lens is the observed one.
        state: Where to evaluate.
    """
    built = [block for build in _BUILDERS for block in build(network, layout, state)]
    built += told.camera(network, layout, start, state)
    return [*built, *told.lens(network, layout, start, state)]

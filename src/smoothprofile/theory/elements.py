"""Elements along a radius, fine across an interface and growing away from it."""

import numpy as np

GROWTH = 1.3
SMALLEST = 1e-3


def radial_edges(
    surface: float, thickness: float, wall: float, core: float, edge: float, to_centre: bool
) -> np.ndarray:
    """Edges from the centre (or the core's rim) to the wall, widths in geometric progression.

    surface: radius at which z = (r − surface)/thickness is zero; core, edge: the z between which
    the indicator varies, infinite for a profile with no end. Where they are finite its kinks
    become edges. The centre itself is singular, so the first edge stands at 1e-3 surface; what
    that leaves out of a drag is of the order of its square.
    """
    if np.isinf(core):
        outward = _away(surface, wall, 0.4 * thickness)
        inward = _towards_centre(surface, 0.4 * thickness)
        return np.concatenate((inward, outward[1:]))
    rim, end = surface + core * thickness, surface + edge * thickness
    across = np.linspace(rim, end, 9)
    outward = _away(end, wall, 0.2 * thickness)
    if not to_centre:
        return np.concatenate((across, outward[1:]))
    inward = _towards_centre(rim, 0.2 * thickness)
    return np.concatenate((inward, across[1:], outward[1:]))


def _away(start: float, stop: float, width: float) -> np.ndarray:
    """Rising edges from start to stop, the first width at most the one asked for."""
    count = int(np.ceil(np.log1p((stop - start) / width * (GROWTH - 1)) / np.log(GROWTH)))
    reach = np.expm1(np.arange(count + 1) * np.log(GROWTH))
    return start + (stop - start) * reach / reach[-1]


def _towards_centre(start: float, width: float) -> np.ndarray:
    """Rising edges from 1e-3 start to start; no element spans more than a factor of two."""
    edges = [start]
    while edges[-1] > SMALLEST * start:
        edges.append(max(edges[-1] - width, 0.5 * edges[-1]))
        width *= GROWTH
    return np.array(edges[::-1])

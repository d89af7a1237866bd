"""Signed distance d and curvature κ₁ + κ₂ of the elementary shapes, as scalar kernels.

d < 0 inside, |∇d| = 1, and κ₁ + κ₂ = ∇²d on the surface (positive where it bulges outwards).
Points are given in the shape's own frame; `s0, s1, s2` are its sizes:

| kind      | s0, s1, s2             | solid                                             |
|-----------|------------------------|---------------------------------------------------|
| SPHERE    | radius                 | about the origin                                  |
| ELLIPSOID | three radii            | along x, y, z                                     |
| CYLINDER  | radius, half length    | along z; the half length may be infinite          |
| CAPSULE   | radius, half length    | along z; half length of the straight part         |
| BOX       | three half sides       | about the origin                                  |
| PLANE     |                        | z < 0                                             |
| MESH + m  |                        | row m of a table of sampled surfaces, `surfaces`  |

The kernels allocate nothing, work in float64 and may be called for each cell from a parallel loop.
"""

import math

import numpy as np
from numba import njit

from smoothprofile.surfaces import Samples, exact_distance

SPHERE = 0
ELLIPSOID = 1
CYLINDER = 2
CAPSULE = 3
BOX = 4
PLANE = 5
MESH = 6

# Newton's method below takes 4 to 6 steps for most points, and less than 50 for the worst found.
_MOST_STEPS = 100
# Quadratic convergence: a last step of this size leaves an error of its square.
_LAST_STEP = 1e-8
# Moving a point by less than round-off keeps the poles of G apart from the points at rest on them.
_NEGLIGIBLE = 1e-17
_TINY = 1e-300


@njit(error_model="numpy")
def signed_distance(
    kind: int, s0: float, s1: float, s2: float, x: float, y: float, z: float
) -> float:
    """d(x, y, z), the distance to the surface, negative inside; lengths in the caller's unit.

    sphere |x| − a;  plane z;  capsule |(x, y, z − clip(z, −h, h))| − a;
    box and cylinder |max(q, 0)| + min(max q, 0), q = |x| − half sides, or (r − a, |z| − h);
    ellipsoid by `_ellipsoid_distance`. All are exact, also outside edges and inside; NaN for any
    other kind.
    """
    if kind == SPHERE:
        return math.sqrt(x * x + y * y + z * z) - s0
    if kind == ELLIPSOID:
        return _ellipsoid_distance(s0, s1, s2, x, y, z)
    if kind == CYLINDER:
        return _box_distance(math.sqrt(x * x + y * y) - s0, abs(z) - s1, -math.inf)
    if kind == CAPSULE:
        beyond = max(abs(z) - s1, 0.0)
        return math.sqrt(x * x + y * y + beyond * beyond) - s0
    if kind == BOX:
        return _box_distance(abs(x) - s0, abs(y) - s1, abs(z) - s2)
    if kind == PLANE:
        return z
    return math.nan


@njit(error_model="numpy")
def curvature(kind: int, s0: float, s1: float, s2: float, x: float, y: float, z: float) -> float:
    """κ₁ + κ₂ at the surface point nearest to (x, y, z), in 1/length.

    sphere 2/a;  cylinder 1/a on its side, 0 on its ends;  capsule 1/a on its side, 2/a on its
    caps;  box and plane 0;  ellipsoid by `_ellipsoid_curvature`. An edge has no curvature of its
    own and counts as one of its faces: a cylinder's rim as the side where r − a ≥ |z| − h.
    """
    if kind == SPHERE:
        return 2.0 / s0
    if kind == ELLIPSOID:
        return _ellipsoid_curvature(s0, s1, s2, x, y, z)
    if kind == CYLINDER:
        return 1.0 / s0 if math.sqrt(x * x + y * y) - s0 >= abs(z) - s1 else 0.0
    if kind == CAPSULE:
        return 2.0 / s0 if abs(z) > s1 else 1.0 / s0
    if kind in (BOX, PLANE):
        return 0.0
    return math.nan


@njit(error_model="numpy")
def union_distance(
    kinds: np.ndarray,
    sizes: np.ndarray,
    positions: np.ndarray,
    matrices: np.ndarray,
    x: float,
    y: float,
    z: float,
    samples: Samples | None = None,
) -> float:
    """d = minᵢ dᵢ(Rᵢᵀ(x − Xᵢ)), the parts' distances at a point of the body's frame.

    `kinds` (n,), `sizes` (n, 3), `positions` X (n, 3), `matrices` R (n, 3, 3) from part to body;
    `samples` holds the surfaces of parts of kind MESH + m.
    Exact outside; inside, where parts overlap, |d| is at most the distance to the surface.
    """
    d = math.inf
    for i in range(kinds.size):
        u, v, w = x - positions[i, 0], y - positions[i, 1], z - positions[i, 2]
        r = matrices[i]
        p = r[0, 0] * u + r[1, 0] * v + r[2, 0] * w
        q = r[0, 1] * u + r[1, 1] * v + r[2, 1] * w
        s = r[0, 2] * u + r[1, 2] * v + r[2, 2] * w
        d_part = signed_distance(kinds[i], sizes[i, 0], sizes[i, 1], sizes[i, 2], p, q, s)
        # Compiled away where there are no samples.
        if samples is not None:  # noqa: SIM102
            if kinds[i] >= MESH:
                d_part = exact_distance(samples, kinds[i] - MESH, p, q, s)
        d = min(d, d_part)
    return d


@njit(error_model="numpy", cache=True)
def fill_union_distance(
    kinds: np.ndarray,
    sizes: np.ndarray,
    positions: np.ndarray,
    matrices: np.ndarray,
    samples: Samples,
    points: np.ndarray,
    out: np.ndarray,
) -> None:
    """out[m] = `union_distance` at points[m]; `points` (m, 3), `out` (m,)."""
    for m in range(out.size):
        out[m] = union_distance(
            kinds, sizes, positions, matrices, points[m, 0], points[m, 1], points[m, 2], samples
        )


@njit(error_model="numpy")
def _box_distance(p: float, q: float, r: float) -> float:
    """|max((p, q, r), 0)| + min(max(p, q, r), 0); an argument −∞ takes no part."""
    p_out, q_out, r_out = max(p, 0.0), max(q, 0.0), max(r, 0.0)
    return math.sqrt(p_out * p_out + q_out * q_out + r_out * r_out) + min(max(p, q, r), 0.0)


@njit(error_model="numpy")
def _ellipsoid_root(
    a: float, b: float, c: float, x: float, y: float, z: float
) -> tuple[float, float, float, float, float, float, float]:
    """s ≥ 0 with G(s) = Σ (eᵢyᵢ/(s + qᵢ))² = 1, qᵢ = eᵢ² − m², m = min eᵢ; 0 if G(0⁺) ≤ 1.

    The surface point nearest to y is eᵢ²yᵢ/(t + eᵢ²) with t = s − m² (Eberly, *Distance from a
    Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid*, Geometric Tools, 2013). 1/√G is
    concave and increasing (Moré & Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983), so Newton's
    method on it, begun at Eberly's lower bound maxᵢ(eᵢ|yᵢ| − qᵢ), climbs to the root without
    passing it and needs no bracket; for a sphere one step is exact.
    Returns s, |y| with round-off removed, and wᵢ = 1/(s + qᵢ).
    """
    m = min(a, b, c)
    q_a, q_b, q_c = (a - m) * (a + m), (b - m) * (b + m), (c - m) * (c + m)
    x, y, z = abs(x), abs(y), abs(z)
    x = x if x > _NEGLIGIBLE * m else 0.0
    y = y if y > _NEGLIGIBLE * m else 0.0
    z = z if z > _NEGLIGIBLE * m else 0.0
    ax, by, cz = a * x, b * y, c * z
    s = max(ax - q_a, by - q_b, cz - q_c, 0.0)
    # A component on its own pole, s + q = 0, is zero here, and 0/_TINY is the right limit 0.
    w_a, w_b, w_c = 1.0 / max(s + q_a, _TINY), 1.0 / max(s + q_b, _TINY), 1.0 / max(s + q_c, _TINY)
    for _ in range(_MOST_STEPS):
        g_a, g_b, g_c = (ax * w_a) ** 2, (by * w_b) ** 2, (cz * w_c) ** 2
        g = g_a + g_b + g_c
        if g <= 1.0:
            break
        step = g * (math.sqrt(g) - 1.0) / (g_a * w_a + g_b * w_b + g_c * w_c)
        s += step
        w_a, w_b, w_c = 1.0 / (s + q_a), 1.0 / (s + q_b), 1.0 / (s + q_c)
        if step <= _LAST_STEP * s:
            break
    return s, x, y, z, w_a, w_b, w_c


@njit(error_model="numpy")
def _ellipsoid_distance(a: float, b: float, c: float, x: float, y: float, z: float) -> float:
    """d = sign(t) √(t (Σ yᵢ²/(t + eᵢ²) − 1)), t from `_ellipsoid_root`.

    d² is the dual of min |x − y|² on the surface and stationary at the root, so that it also
    holds on the planes of symmetry near the centre, where the nearest point leaves the plane.
    """
    s, x, y, z, w_a, w_b, w_c = _ellipsoid_root(a, b, c, x, y, z)
    m = min(a, b, c)
    t = s - m * m
    d_squared = t * (x * x * w_a + y * y * w_b + z * z * w_c - 1.0)
    return math.copysign(math.sqrt(max(d_squared, 0.0)), t)


@njit(error_model="numpy")
def _ellipsoid_curvature(a: float, b: float, c: float, x: float, y: float, z: float) -> float:
    """κ₁ + κ₂ = Σ hᵢ(1 − nᵢ²)/|g|, hᵢ = 1/eᵢ², gᵢ = xᵢ/eᵢ², n = g/|g|, at the nearest point x."""
    s, x, y, z, w_a, w_b, w_c = _ellipsoid_root(a, b, c, x, y, z)
    m = min(a, b, c)
    h_a, h_b, h_c = 1.0 / (a * a), 1.0 / (b * b), 1.0 / (c * c)
    g_a, g_b, g_c = (x * w_a) ** 2, (y * w_b) ** 2, (z * w_c) ** 2
    # With s = 0 the nearest point lies off the plane of symmetry, by what is left of Σ xᵢ²/eᵢ² = 1.
    g_m = 0.0
    if s == 0.0:
        g_m = max(1.0 - a * a * g_a - b * b * g_b - c * c * g_c, 0.0) / (m * m)
    g = g_a + g_b + g_c + g_m
    bent = h_a * (g - g_a) + h_b * (g - g_b) + h_c * (g - g_c) - g_m / (m * m)
    return bent / (g * math.sqrt(g))

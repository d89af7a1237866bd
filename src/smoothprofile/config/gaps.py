"""How near bodies of a case stand to each other at its start, periodic images counted.

    gap = min over x of the first body's points of d(x) − ρ,   d the distance to the second body

x and ρ as in `overlap.py`; of two spheres |x₁ − x₂| − a₁ − a₂.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from smoothprofile.config.domain import Domain
from smoothprofile.config.overlap import Placed
from smoothprofile.config.particle import Particle, build_shape
from smoothprofile.structure import Beads

MOST_PAIRS = 2000
"""Of other shapes than spheres, that are looked at one by one."""


def smallest_gap(
    particles: Sequence[Particle], domain: Domain, below: float
) -> tuple[float, str, str] | None:
    """The smallest gap under `below` and the names of its two bodies; None if all are wider.

    A body and its own image have one name. Bodies without an end count beside others alone.
    """
    farthest = float(np.linalg.norm(domain.lengths))
    bodies = [Placed(i, p, build_shape(p), farthest) for i, p in enumerate(particles)]
    found = [*_own_images(bodies, domain), *_of_spheres(bodies, domain, below)]
    others = [b for b in bodies if b.particle.shape != "sphere"]
    pairs = itertools.chain.from_iterable(_near(b, bodies, domain, below) for b in others)
    for first, second, shift in itertools.islice(pairs, MOST_PAIRS):
        gap = min(_between(first, second, shift), _between(second, first, -shift))
        found.append((gap, first.particle.name, second.particle.name))
    return min((gap for gap in found if gap[0] < below), default=None)


def _own_images(bodies: list[Placed], domain: Domain) -> list[tuple[float, str, str]]:
    """From each bounded body along each period to its image."""
    found = []
    for body in (body for body in bodies if body.particle.bounded):
        width, name = np.subtract(*body.extents[::-1]), body.particle.name
        room = np.where(domain.periodic, domain.lengths - width, math.inf)
        found.append((float(room.min()), name, name))
    return found


def _of_spheres(bodies: list[Placed], domain: Domain, below: float) -> list[tuple[float, str, str]]:
    """The narrowest gap of each sphere that has one, to spheres no larger."""
    spheres = [body for body in bodies if body.particle.shape == "sphere"]
    if len(spheres) < 2:
        return []
    radii = np.array([body.particle.radius for body in spheres])
    centres, box = np.array([body.position for body in spheres]), (domain.origin, domain.lengths)
    beads = Beads(centres, radii, *map(np.array, box), np.array(domain.periodic))
    places, periods = beads.wrapped, beads.period
    near = cKDTree(places, boxsize=periods).query_ball_point(places, 2.0 * radii + below)
    found = []
    for i, others in enumerate(near):
        others = np.array([j for j in others if (radii[j], j) < (radii[i], i)], dtype=int)
        apart = places[others] - places[i]
        apart -= periods * np.round(apart / beads.lengths)
        gaps = np.linalg.norm(apart, axis=1) - radii[others] - radii[i]
        if gaps.size:
            j = int(gaps.argmin())
            names = spheres[others[j]].particle.name, spheres[i].particle.name
            found.append((float(gaps[j]), *names))
    return found


def _near(body: Placed, bodies: list[Placed], domain: Domain, below: float):
    """(body, other, shift of the other) for pairs whose enclosing balls are that near, once."""
    steps = [(-1, 0, 1) if periodic else (0,) for periodic in domain.periodic]
    shifts = np.array(list(itertools.product(*steps))) * domain.lengths
    for other in bodies:
        twice = other.particle.shape != "sphere" and other.number >= body.number
        if twice or not (body.particle.bounded or other.particle.bounded):
            continue
        whole, ball = (other, body) if body.particle.bounded else (body, other)
        sign = 1.0 if whole is other else -1.0
        apart = whole.distance(ball.position - sign * shifts) - ball.shape.reach
        for shift in shifts[apart < below]:
            yield body, other, shift


def _between(first: Placed, second: Placed, shift: np.ndarray) -> float:
    """From the points of `first` to `second` moved by `shift`."""
    points, radii = first.core
    return float((second.distance(points - shift) - radii).min())

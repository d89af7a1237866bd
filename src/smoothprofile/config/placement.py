"""Where bodies may stand: inside the domain, clear of its walls and of each other."""

from collections.abc import Sequence

import numpy as np

from smoothprofile.config.domain import Domain
from smoothprofile.config.overlap import TOUCHING, Placed, first_overlap
from smoothprofile.config.particle import Particle, build_shape, shown_signal
from smoothprofile.config.refusals import Refusal
from smoothprofile.config.values import AXES

# Directions typed with nine digits still count as along an axis.
ALIGNED = 1e-8


def check_placement(particles: Sequence[Particle], domain: Domain) -> None:
    """Refusal of the first body that stands where it may not."""
    farthest = float(np.linalg.norm(domain.lengths))
    bodies = [
        Placed(number, particle, build_shape(particle), farthest)
        for number, particle in enumerate(particles)
    ]
    for body in bodies:
        _check_position(body, domain)
        if body.particle.bounded:
            _check_walls(body, domain)
        else:
            _check_unbounded(body, domain)
    pair = first_overlap(bodies, domain)
    if pair is not None:
        body, other = pair
        what = f"particles.{other.number} at {list(other.particle.position)}"
        if other is body:
            what = "its own periodic image"
        allowed = f"the body there overlaps {what}, and bodies must be clear of each other"
        raise Refusal(f"{body.key}.position", body.particle.position, allowed)


def _check_position(body: Placed, domain: Domain) -> None:
    for axis, coordinate in enumerate(body.particle.position):
        if not domain.contains(axis, coordinate):
            allowed = f"it must lie within the domain, {domain.reach(axis)} along {AXES[axis]}"
            raise Refusal(f"{body.key}.position", body.particle.position, allowed)


def _check_walls(body: Placed, domain: Domain) -> None:
    gaps = np.minimum(body.position - domain.origin, np.subtract(domain.high, body.position))
    if np.all(domain.periodic | (gaps >= body.shape.reach)):
        return
    low, high = body.extents
    for axis in range(3):
        room = TOUCHING * domain.lengths[axis]
        sticks = low[axis] < domain.origin[axis] - room or high[axis] > domain.high[axis] + room
        if sticks and not domain.periodic[axis]:
            allowed = (
                f"the body there takes up {low[axis]:.6g} to {high[axis]:.6g} along {AXES[axis]}, "
                f"and must stay between the walls, {domain.reach(axis)}"
            )
            raise Refusal(f"{body.key}.position", body.particle.position, allowed)


def _check_unbounded(body: Placed, domain: Domain) -> None:
    """Bodies without an end must fit the axes, and go on doing so when they turn."""
    particle, along = body.particle, np.abs(body.axis)
    key = next((k for k in ("axis", "normal") if getattr(particle, k)), "orientation")
    value = particle.direction or (particle.orientation and particle.orientation.model_dump())
    if particle.shape == "cylinder" and np.sum(along > ALIGNED) > 1:
        allowed = "a cylinder without a length must lie along x, y or z"
        raise Refusal(f"{body.key}.{key}", value, allowed)
    if particle.shape == "plane" and np.any(along[list(domain.periodic)] > ALIGNED):
        allowed = "a plane must face along axes that have walls, for it has no periodic image"
        raise Refusal(f"{body.key}.{key}", value, allowed)
    turning = particle.angular_velocity
    for spin in (turning.constant, turning.amplitude):
        if np.linalg.norm(np.cross(body.axis, spin)) > ALIGNED * np.linalg.norm(spin):
            allowed = "a body without an end turns only about its own axis"
            raise Refusal(f"{body.key}.angular_velocity", shown_signal(turning), allowed)

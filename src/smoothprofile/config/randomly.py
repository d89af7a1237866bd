"""Random packings of a case: how many bodies, what stands in their way, and where they go.

Spheres are packed as they are, other bodies by the ball about their position that encloses them.
"""

import itertools

import numpy as np

from smoothprofile.config.domain import Domain
from smoothprofile.config.overlap import Placed
from smoothprofile.config.particle import Particle, build_shape
from smoothprofile.config.radii import Radii
from smoothprofile.config.refusals import Refusal
from smoothprofile.config.tables import RandomPacking
from smoothprofile.packing import DENSEST, Room, pack
from smoothprofile.rotations import normalise
from smoothprofile.shapes import Shape

MOST_BODIES = 100_000
JAMMED = 0.66


def place_randomly(
    table: RandomPacking,
    radii: Radii | None,
    shape: Shape,
    domain: Domain,
    standing: list[Particle],
    key: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions (n, 3), radii of the enclosing balls (n,) and quaternions (n, 4) of the bodies.

    `standing` are the bodies that are there already. Refusal if no room is found for them.
    """
    generator = np.random.default_rng(table.seed)
    low, high = _corners(table, domain, key)
    balls = _balls(table, radii, shape, float(np.prod(high - low)), generator, key)
    turns = normalise(generator.normal(size=(len(balls), 4)))
    room = _room(table, domain, low, high, balls, standing)
    # What is too large for any number is too large for the room.
    with np.errstate(over="ignore"):
        inflated = float(np.sum(4.0 / 3.0 * np.pi * (balls + 0.5 * table.gap) ** 3))
    amount = "count" if table.count is not None else "volume_fraction"
    share = inflated / float(np.prod(high - low))
    found = None
    # Equal balls jam at random at .64, and even of many sizes what is denser than their densest
    # packing is not worth the try; nor are balls wider than the room.
    most = JAMMED if np.ptp(balls) == 0.0 else 1.05 * DENSEST
    if share < most and np.all(room.low <= room.high):
        found = pack(balls, table.gap, room, generator)
    if found is None:
        allowed = (
            f"no room was found for {len(balls)} bodies, whose enclosing balls with half the gap "
            f"around them fill {share:.3g} of it; take fewer, smaller or nearer ones"
        )
        raise Refusal(f"{key}.random.{amount}", getattr(table, amount), allowed)
    return found + domain.origin, balls, turns


def _corners(table: RandomPacking, domain: Domain, key: str) -> tuple[np.ndarray, np.ndarray]:
    """Of the room for the bodies, counted from the domain's low corner."""
    if table.box is None:
        return np.zeros(3), np.array(domain.lengths)
    for end in ("low", "high"):
        corner = getattr(table.box, end)
        if not all(domain.contains(axis, c) for axis, c in enumerate(corner)):
            reaches = ", ".join(domain.reach(axis) for axis in range(3))
            allowed = f"it must lie within the domain, {reaches} along x, y, z"
            raise Refusal(f"{key}.random.box.{end}", corner, allowed)
    return np.subtract(table.box.low, domain.origin), np.subtract(table.box.high, domain.origin)


def _balls(
    table: RandomPacking,
    radii: Radii | None,
    shape: Shape,
    volume: float,
    generator: np.random.Generator,
    key: str,
) -> np.ndarray:
    """Radii of the enclosing balls."""
    spheres = shape.name == "sphere"
    if radii is not None and not spheres and len(radii.dealt) != 1:
        shown = radii.dealt or radii.table.model_dump(exclude_none=True)
        allowed = f"bodies of a random packing may differ in radius if spheres, not a {shape.name}"
        raise Refusal(f"{key}.radius", shown, allowed)
    number = table.count
    if number is None:
        each = 4.0 / 3.0 * np.pi * radii.mean_cube if spheres else shape.volume
        number = max(1, round(min(table.volume_fraction * volume / each, 1e9)))
    if number > MOST_BODIES:
        amount = "count" if table.count is not None else "volume_fraction"
        allowed = f"these are {number} bodies, and a case has {MOST_BODIES} at most"
        raise Refusal(f"{key}.random.{amount}", getattr(table, amount), allowed)
    if not spheres:
        return np.full(number, shape.reach)
    balls = radii.draw(number, generator)
    if table.count is None and radii.table is not None:
        balls = _trimmed(balls, radii, table.volume_fraction * volume, generator)
    return balls


def _trimmed(
    balls: np.ndarray, radii: Radii, wanted: float, generator: np.random.Generator
) -> np.ndarray:
    """So many drawn balls that their volume is nearest to what is wanted."""
    balls = np.concatenate([balls, radii.draw(max(10, len(balls)), generator)])
    volumes = np.cumsum(4.0 / 3.0 * np.pi * balls**3)
    return balls[: max(1, 1 + int(np.argmin(np.abs(volumes - wanted))))]


def _room(
    table: RandomPacking,
    domain: Domain,
    low: np.ndarray,
    high: np.ndarray,
    balls: np.ndarray,
    standing: list[Particle],
) -> Room:
    """Where the centres may be: whole balls in the box, a gap from the walls."""
    whole = (low <= 0.0) & (high >= np.array(domain.lengths))
    open_ended = whole & np.array(domain.periodic)
    lows, highs = np.tile(low, (len(balls), 1)), np.tile(high, (len(balls), 1))
    for axis in np.flatnonzero(~open_ended):
        wall = 0.0 if domain.periodic[axis] else table.gap
        lows[:, axis] = np.maximum(lows[:, axis], wall) + balls
        highs[:, axis] = np.minimum(highs[:, axis], domain.lengths[axis] - wall) - balls
    spheres, solids = [], []
    farthest = float(np.linalg.norm(domain.lengths))
    margin = 3.0 * float(balls.max()) + table.gap
    for particle in standing:
        if particle.shape == "sphere":
            spheres.append((*np.subtract(particle.position, domain.origin), particle.radius))
        else:
            body = Placed(0, particle, build_shape(particle), farthest)
            solids.append(_solid(body, domain, margin))
    fixed = np.array(spheres, dtype=np.float64).reshape(-1, 4)
    periods = np.where(domain.periodic, domain.lengths, 0.0)
    return Room(lows, highs, periods, open_ended, fixed[:, :3], fixed[:, 3], solids)


def _solid(body: Placed, domain: Domain, margin: float):
    """Signed distance to a body and its images nearer than `margin` to the domain.

    Of points (k, 3) counted from the domain's low corner.
    """
    origin, lengths = np.array(domain.origin), np.array(domain.lengths)
    steps = [(-1.0, 0.0, 1.0) if periodic else (0.0,) for periodic in domain.periodic]
    shifts = np.array(list(itertools.product(*steps))) * domain.lengths
    places = body.position - origin + shifts
    outside = np.linalg.norm(np.maximum(0.0, np.maximum(-places, places - lengths)), axis=1)
    shifts = shifts[outside <= body.shape.reach + margin]

    def distance(points: np.ndarray) -> np.ndarray:
        inside = np.where(domain.periodic, points % lengths, points)
        return np.min([body.distance(inside + origin - shift) for shift in shifts], axis=0)

    return distance

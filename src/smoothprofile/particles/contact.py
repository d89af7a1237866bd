"""Contact of bodies with each other and with walls, in sub-steps of the fluid's step.

    V(t) = V̄ + V̇(t − Δt/2) + ΣJ/m,   Ω(t) likewise,   R₁ = R₀ + ∫V dt

V̄ and V̇ are what the fluid and the loads make of the bodies' motion, J the impulses of contact and m
the mass that a body moves with in the fluid. The total J of a step is handed back: it belongs on
the right-hand side of the bodies' equation of motion. Laws: `contact_law`; order: `contact_sweep`.
Each pair of parts meets in its nearest periodic image alone.
"""

import math
from dataclasses import dataclass

import numpy as np

from smoothprofile import rotations
from smoothprofile.distances import SPHERE
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.contact_pairs import Neighbours, bounding_radii
from smoothprofile.particles.contact_parameters import ContactParameters as ContactParameters
from smoothprofile.particles.contact_parameters import default_parameters as default_parameters
from smoothprofile.particles.contact_sweep import (
    Box,
    Course,
    MassTable,
    PartTable,
    Scratch,
    sweep,
)

# ωδt of the stiffest pair: 12 sub-steps for half a period, an eighth of what would be unstable.
_PHASE = 0.25
# Of the range, in one sub-step.
_FARTHEST = 0.25


@dataclass
class ContactHistory:
    """What a restart needs: ΣJ/m and ΣI⁻¹T of the last step, (n,3) each."""

    velocity_gain: np.ndarray
    spin_gain: np.ndarray

    @classmethod
    def none(cls, count: int) -> "ContactHistory":
        return cls(np.zeros((count, 3)), np.zeros((count, 3)))


@dataclass(frozen=True, eq=False)
class Moved:
    """Where bodies are after the step, and what contact gave them: J and T about their positions.

    wall_impulse (axis, side, 3) is what the walls got; least_gap the least met, inf if none were
    near; substeps how many were taken, 1 if nothing could touch.
    """

    position: np.ndarray
    quaternion: np.ndarray
    impulse: np.ndarray
    angular_impulse: np.ndarray
    wall_impulse: np.ndarray
    history: ContactHistory
    substeps: int
    least_gap: float


def driven(newer: np.ndarray, older: np.ndarray, gain: np.ndarray, dt: float) -> tuple:
    """V̄ = (3Vⁿ − Vⁿ⁻¹ − g)/2 and V̇ = (Vⁿ − Vⁿ⁻¹ − g)/Δt; g what contact added in the last step.

    Without g, a bounce would go on into the next step half as strong again.
    """
    return 1.5 * newer - 0.5 * older - 0.5 * gain, (newer - older - gain) / dt


class Contact:
    """Contact among given bodies in a given box."""

    _sweep = staticmethod(sweep)

    def __init__(
        self,
        forms: Forms,
        grid: Grid,
        inverse_mass: np.ndarray,
        inverse_inertia: np.ndarray,
        parameters: ContactParameters,
    ):
        """inverse_mass (n,) and inverse_inertia (n,3,3), along the body's axes about its position,
        of the body as it moves in the fluid; 0 for bodies that are held or moved."""
        self.parameters, self._law = parameters, parameters.law
        count = inverse_mass.size
        parts = PartTable(
            np.repeat(np.arange(count), np.diff(forms.part_start)),
            forms.kind,
            forms.size,
            forms.place,
            forms.turn,
            bounding_radii(forms.kind, forms.size),
        )
        self._parts, self._masses = parts, _masses(parts, inverse_mass, inverse_inertia, parameters)
        low = np.array([axis.low for axis in grid.axes])
        period = np.where(grid.periodic, grid.lengths, 0.0)
        self._box = Box(low, np.array([a.high for a in grid.axes]), period, np.zeros((3, 2, 3)))
        mobile = inverse_mass[parts.body] > 0.0
        self._near = Neighbours(
            parts.body, parts.kind, parts.radius, mobile, low, self._box.high, period
        )
        self._cutoff = max(parameters.range, parameters.outer_gap * (parameters.viscosity > 0.0))
        self._inverse = _inverse_mass_bound(self._masses)
        self._rows = np.zeros((0, 3), np.int64)
        self._built, self._skin = np.full((parts.body.size, 3), np.inf), 0.0

    def move(
        self,
        position: np.ndarray,
        quaternion: np.ndarray,
        velocity: tuple[np.ndarray, np.ndarray],
        spin: tuple[np.ndarray, np.ndarray],
        dt: float,
        wall_velocity: np.ndarray | None = None,
    ) -> Moved:
        """Bodies Δt later; velocity and spin are (mean, rate of change), (n,3) each, as `driven`
        gives them, of all bodies, those that are held or moved too.

        Sub-steps: as many that ωδt ≤ 1/4 for the stiffest pair, ω² = 2F₀/(s m), and that no pair
        closes by more than s/4 in one. A body that nothing touches moves by Δt V̄ exactly.
        wall_velocity (axis, side, 3).
        """
        box = self._box
        if wall_velocity is not None:
            box = box._replace(wall_velocity=np.asarray(wall_velocity, dtype=np.float64))
        course = Course(position.copy(), *velocity, *spin)
        course = Course(*(np.ascontiguousarray(a, dtype=np.float64) for a in course))
        s = _scratch(self._parts, course, quaternion)
        fastest = self._speeds(course, dt)
        centre = self._centres(position, quaternion)
        skin = max(self.parameters.range, 3.0 * dt * fastest.max(initial=0.0))
        self._refresh(centre, skin)
        count = self._substeps(centre, course, fastest, box, dt)
        least, done = math.inf, 0
        start = np.full((self._rows.shape[0], 3), np.nan)
        while count and done <= count:
            done, gap = self._sweep(
                done, count, dt, self._rows, start, self._built, 0.5 * self._skin, self._cutoff,
                self._parts, self._masses, box, self._law, course, s,
            )  # fmt: skip
            least = min(least, gap)
            if done <= count:
                self._build(s.centre.copy(), skin)
                start = np.full((self._rows.shape[0], 3), np.nan)
        return self._moved(course, quaternion, s, dt, max(count, 1), least)

    def _moved(self, course, quaternion, s, dt, substeps, least) -> Moved:
        turned = rotations.normalise(
            rotations.multiply(rotations.from_vector(dt * course.spin), quaternion)
        )
        kicked = np.any(s.angular_impulse != 0.0, axis=1)
        turned[kicked] = rotations.normalise(s.quaternion[kicked])
        return Moved(
            position=course.origin + dt * course.velocity + s.shift,
            quaternion=turned,
            impulse=s.impulse,
            angular_impulse=s.angular_impulse,
            wall_impulse=s.wall_impulse,
            history=ContactHistory(s.gain, s.spin_gain),
            substeps=substeps,
            least_gap=least,
        )

    def _speeds(self, course: Course, dt: float) -> np.ndarray:
        """(n,): no point of the body's surface is faster, as long as nothing touches it."""
        speed = np.linalg.norm(course.velocity, axis=1)
        speed += 0.5 * dt * np.linalg.norm(course.velocity_rate, axis=1)
        turning = np.linalg.norm(course.spin, axis=1)
        turning += 0.5 * dt * np.linalg.norm(course.spin_rate, axis=1)
        return speed + np.where(self._masses.ball, 0.0, turning * self._masses.reach)

    def _substeps(self, centre, course, fastest, box, dt) -> int:
        """How many; 0 if nothing can come into reach within Δt."""
        rows = self._rows
        if not rows.size:
            return 0
        first, other = rows[:, 0], rows[:, 1]
        body = self._parts.body
        b, wall = body[first], other < 0
        o = body[np.where(wall, first, other)]
        gap = self._ball_gaps(centre, first, other, wall)
        mean = course.velocity
        axis, side = _wall_of(other)
        wall_speed = np.linalg.norm(box.wall_velocity, axis=-1)[axis, side]
        own = fastest - np.linalg.norm(mean, axis=1)
        closing = np.where(
            wall,
            fastest[b] + wall_speed,
            np.linalg.norm(mean[b] - mean[o], axis=1) + own[b] + own[o],
        )
        near = gap < self._cutoff + dt * closing
        if not near.any():
            return 0
        softness, inverse = 1.0 / self._masses.touch_force, self._inverse
        touch = 1.0 / (softness[b] + np.where(wall, 0.0, softness[o]))
        mobility = inverse[b] + np.where(wall, 0.0, inverse[o])
        s = self.parameters.range
        stiff = self._stiffness(2.0 * touch * mobility / s, dt) / _PHASE
        needed = np.maximum(stiff, dt * closing / (_FARTHEST * s))[near].max()
        return int(min(max(math.ceil(needed), 1), self.parameters.most_substeps))

    def _stiffness(self, rate: np.ndarray, dt: float) -> np.ndarray:
        """ωΔt of each pair, from ω²."""
        return dt * np.sqrt(rate)

    def _ball_gaps(self, centre, first, other, wall) -> np.ndarray:
        """(rows,): no more than the gaps, from the balls that enclose the parts."""
        radius, period = self._parts.radius, self._box.period
        axis, side = _wall_of(other)
        x = centre[first, axis]
        from_wall = np.where(side == 0, x - self._box.low[axis], self._box.high[axis] - x)
        second = np.where(wall, first, other)
        apart = centre[first] - centre[second]
        apart -= period * np.round(apart / np.where(period > 0.0, period, 1.0))
        # A part without end is taken to be near: infinity less infinity would be no number.
        reach = np.where(np.isfinite(radius[second]), radius[second], 1e300)
        between = np.linalg.norm(apart, axis=1) - reach
        return np.where(wall, from_wall, between) - radius[first]

    def _centres(self, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
        body = self._parts.body
        return position[body] + rotations.rotate(quaternion[body], self._parts.place)

    def _refresh(self, centre: np.ndarray, skin: float) -> None:
        """Keep the candidates unless a part has used up a quarter of the skin, or it is too thin.

        What they are changes no bit of a result, as long as none is missing.
        """
        moved = np.linalg.norm(centre - self._built, axis=1).max(initial=0.0)
        if moved > 0.25 * self._skin or not 0.5 * skin <= self._skin <= 2.0 * skin:
            self._build(centre, 2.0 * skin)

    def _build(self, centre: np.ndarray, skin: float) -> None:
        self._rows = self._near.within(centre, self._cutoff + skin)
        self._built, self._skin = centre, skin


def _wall_of(other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axis and side of the walls among the candidates; anything for the rest."""
    number = np.maximum(-1 - other, 0)
    return number // 2, number % 2


def _masses(parts: PartTable, inverse_mass, inverse_inertia, parameters) -> MassTable:
    count = inverse_mass.size
    tip = np.where(np.isfinite(parts.radius), parts.radius, parts.size[:, 0])
    reach = np.zeros(count)
    np.maximum.at(reach, parts.body, np.linalg.norm(parts.place, axis=1) + tip)
    inverse_inertia = np.ascontiguousarray(inverse_inertia, dtype=np.float64)
    round_part = (parts.kind == SPHERE) & ~np.any(parts.place, axis=1)
    ball = np.bincount(parts.body, minlength=count) == 1
    ball &= np.bincount(parts.body, round_part, minlength=count) > 0
    even = inverse_inertia[:, :1, :1] * np.eye(3)
    # Moments from a formula differ by round-off at most.
    scale = 1e-12 * np.abs(even).max(axis=(1, 2))
    ball &= np.abs(inverse_inertia - even).max(axis=(1, 2)) <= scale
    force = np.broadcast_to(np.asarray(parameters.touch_force, dtype=np.float64), (count,)).copy()
    force[inverse_mass == 0.0] = np.inf
    mass = np.ascontiguousarray(inverse_mass, dtype=np.float64)
    return MassTable(mass, inverse_inertia, force, reach, ball)


def _inverse_mass_bound(masses: MassTable) -> np.ndarray:
    """(n,): 1/m + ρ²/I, the most that a body gives way to a push anywhere on it."""
    swing = np.linalg.eigvalsh(masses.inverse_inertia).max(axis=1) * masses.reach**2
    return masses.inverse_mass + np.where(masses.ball, 0.0, swing)


def _scratch(parts: PartTable, course: Course, quaternion: np.ndarray) -> Scratch:
    n, m = course.origin.shape[0], parts.body.size
    impulse, angular, gain, spin_gain, shift, position, velocity, spin = np.zeros((8, n, 3))
    frame = np.broadcast_to(np.eye(3), (m, 3, 3)).copy()
    return Scratch(
        impulse, angular, gain, spin_gain, shift, np.zeros((3, 2, 3)),
        np.array(quaternion, dtype=np.float64), position, velocity, spin, np.zeros((n, 3, 3)),
        np.zeros((m, 3)), frame,
    )  # fmt: skip

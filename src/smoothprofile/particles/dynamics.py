"""Bodies that move freely: Newton and Euler, solved together with the impulse.

    M a = F + W,   F = ρVa − (ργ/Δt)∫f dV,   f = φ(u_p − uˢ)            (F as in `loads.py`)
    ⇒ (M − ρV + C)(γVⁿ⁺¹ − Σα_q Vⁿ⁻q) + ργ∫φ(u_pⁿ⁺¹ − uˢ)dV = WΔt + C aⁿΔt

and so for the moments about the centre of mass, with L = R J Rᵀ Ω in place of V. The impulse is
linear in (V, Ω), so that each body is one 6×6 system, whatever its density. What the fluid gains
the bodies lose, to round-off, as long as C = 0.

C is a virtual mass: a body lighter than its fluid is solved as if neutrally buoyant at least, the
rest of its inertia taken from the step before. Without it the pressure, which answers an
acceleration one step late, would make light bodies unstable. A layer painted thin leaves the
impulse of one step less than the displaced fluid; where M − ρV and that share s together would be
below zero, C grows as ((ρ−ρ_p)/ρs)³. What C takes late it gives back: to round-off,
∫ρu dV + Σ(M−ρV)Vⁿ + C(Vⁿ−Vⁿ⁻¹) stays constant.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import elliprd

from smoothprofile.errors import CaseError
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.contact import Contact, ContactHistory, driven
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.particles.rigid import advance_rotation
from smoothprofile.schemes import Scheme

LEAST_HELD = 1e-6
"""Of the fluid that a body displaces: what the impulse of one step must hold to move it."""
WallVelocity = Callable[[float], np.ndarray]
"""t -> (axis, side, 3), how the walls slide."""


@dataclass(frozen=True, eq=False)
class FreeBodies:
    """rows (m,) of the bodies that are free, their density, and the constant loads on them.

    force and torque (m,3), along the box's axes, about the centre of mass; gravity (3,) pulls at
    what a body weighs more than the fluid that it displaces.
    """

    rows: np.ndarray
    density: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    gravity: np.ndarray


class FreeMotion:
    """Places free bodies and finds their velocities."""

    def __init__(
        self,
        free: FreeBodies,
        displaced: DisplacedFluid,
        density: float,
        contact: Contact,
        wall_velocity: WallVelocity,
    ):
        """displaced, density: of the fluid."""
        self.rows, self.density = free.rows, density
        self.contact, self._wall_velocity = contact, wall_velocity
        volume, inertia = displaced.volume[free.rows], displaced.inertia[free.rows]
        excess = free.density - density
        self._displaced = density * volume, density * inertia
        self._own_inertia = free.density[:, None, None] * inertia
        self._excess = excess * volume, excess[:, None, None] * inertia
        self._take_virtual(
            np.maximum(-excess, 0.0) * volume, np.maximum(-excess, 0.0)[:, None, None] * inertia
        )
        weight = (excess * volume)[:, None] * free.gravity
        self.loads = np.concatenate([free.force + weight, free.torque], axis=1)
        # (m,6) of what acts from afar, at the end of the step under way and at its start.
        self.pulls = [np.zeros_like(self.loads)]
        # What a checkpoint holds besides the bodies' own state, newest level first.
        self.past_spin: list[np.ndarray] = []
        self.past_turning: list[np.ndarray] = []
        self.past_late: list[np.ndarray] = []
        self.contact_history = ContactHistory.none(displaced.volume.size)
        self.contact_impulses: list[np.ndarray] = []
        # (axis, side, 3) of what contact gave the walls in the last step.
        self.wall_impulse = np.zeros((3, 2, 3))

    def place(self, state: BodyState, past: list, time: float, since: float) -> None:
        """Rⁿ⁺¹ = Rⁿ + Δt(3Vⁿ − Vⁿ⁻¹)/2 + contact; past[0] is level n.

        They turn as tops whose angular momentum goes on changing as it did in the step before.
        """
        if not self.rows.size:
            return
        dt, history = time - since, self.contact_history
        newer, older = past[0], past[1] if len(past) > 1 else past[0]
        gains = (history.velocity_gain, history.spin_gain)
        velocity, spin = (driven(*levels, dt) for levels in zip(newer, older, gains, strict=True))
        walls = self._wall_velocity(0.5 * (time + since))
        moved = self.contact.move(state.position, state.quaternion, velocity, spin, dt, walls)
        state.position[self.rows] = moved.position[self.rows]
        kicked = np.any(moved.history.spin_gain[self.rows] != 0.0, axis=1)
        turned = self._turn(state, newer[1], dt)
        turned[kicked] = moved.quaternion[self.rows[kicked]]
        state.quaternion[self.rows] = turned
        self.contact_history, self.wall_impulse = moved.history, moved.wall_impulse
        impulse = np.concatenate([moved.impulse, moved.angular_impulse], axis=1)[self.rows]
        self.contact_impulses.insert(0, impulse)

    def feel(self, pull: np.ndarray) -> None:
        """Take what acts from afar (n,6) where the bodies are at the end of the step."""
        first = len(self.pulls) == 1
        new = pull[self.rows]
        self.pulls = [new, new if first else self.pulls[0]]

    def remember(self, state: BodyState, levels: int) -> None:
        """Keep the angular momenta of the level that is about to become old."""
        turn, rows = state.rotation[self.rows], self.rows
        rate = np.swapaxes(turn, 1, 2) @ state.angular_velocity[rows, :, None]
        inertias = self._inertia, self._virtual_inertia, self._own_inertia
        spin, virtual, own = ((turn @ (inertia @ rate))[..., 0] for inertia in inertias)
        self.past_spin.insert(0, spin)
        self.past_turning.insert(0, own)
        late = [self._virtual[:, None] * state.velocity[rows], virtual]
        self.past_late.insert(0, np.concatenate(late, axis=1))
        del self.past_spin[levels:], self.contact_impulses[levels:], self.past_late[levels + 1 :]
        del self.past_turning[2:]

    def solve(
        self, state: BodyState, past: list, scheme: Scheme, dt: float, matrix, momentum
    ) -> None:
        """Vⁿ⁺¹, Ωⁿ⁺¹ into the state, from ∂(∫f, ∫r×f)/∂(V, Ω) (n,6,6) and ∫φuˢ, ∫r×φuˢ (n,6)."""
        rows, rate = self.rows, self.density * scheme.gamma
        if not rows.size:
            return
        known = np.zeros((rows.size, 6))
        for weight, old, spin in zip(scheme.past, past, self.past_spin, strict=False):
            known[:, :3] += weight * self._mass[:, None] * old[0][rows]
            known[:, 3:] += weight * spin
        new, old = scheme.implicit, 1.0 - scheme.implicit
        known += dt * (self.loads + new * self.pulls[0] + old * self.pulls[-1])
        known += rate * momentum[rows] + self._kick(scheme)
        known += self.late(scheme)
        self._system = self._system_of(state.rotation[rows], scheme, rate, matrix)
        found = np.linalg.solve(self._system, known[..., None])
        state.velocity[rows], state.angular_velocity[rows] = found[:, :3, 0], found[:, 3:, 0]
        self._rate = rate

    def response(self, momentum: np.ndarray) -> np.ndarray:
        """(n,6): what V and Ω as just solved change by when ∫φuˢ, ∫r×φuˢ do by `momentum` (n,6)."""
        gain = np.zeros_like(momentum)
        if self.rows.size:
            right = self._rate * momentum[self.rows]
            gain[self.rows] = np.linalg.solve(self._system, right[..., None])[..., 0]
        return gain

    def late(self, scheme: Scheme) -> np.ndarray:
        """Δt·d(CV)/dt and Δt·d(R C RᵀΩ)/dt (m,6) of the step before, by this step's scheme."""
        levels = self.past_late + self.past_late[-1:] * len(scheme.past)
        change = scheme.gamma * levels[0]
        for weight, old in zip(scheme.past, levels[1:], strict=False):
            change -= weight * old
        return change

    def saved(self) -> dict:
        """What the next step reads besides the bodies' state, for a checkpoint."""
        history = self.contact_history
        return {
            "past_spin": list(self.past_spin),
            "past_late": list(self.past_late),
            "past_turning": list(self.past_turning),
            "velocity_gain": history.velocity_gain,
            "spin_gain": history.spin_gain,
            "contact_impulses": list(self.contact_impulses),
            "wall_impulse": self.wall_impulse,
            "pulls": self.pulls,
        }

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave."""
        self.past_spin, self.past_late = list(saved["past_spin"]), list(saved["past_late"])
        self.past_turning = list(saved["past_turning"])
        self.contact_history = ContactHistory(saved["velocity_gain"], saved["spin_gain"])
        self.contact_impulses = list(saved["contact_impulses"])
        self.wall_impulse = saved["wall_impulse"]
        self.pulls = list(saved["pulls"])

    def learn(self, matrix: np.ndarray) -> None:
        """How much the impulse of a step can hold, from the matrix as in `solve`; once, at rest.

        Of a layer painted thin, that is less than the displaced fluid. See the head of the file.
        """
        (mass, inertia), (excess, excess_inertia) = self._displaced, self._excess
        lack, flat = np.maximum(-excess / mass, 0.0), _flatness(inertia)
        held = self.density * matrix[self.rows]
        share = np.linalg.eigvalsh(held[:, :3, :3])[:, 0] / mass
        turning = np.linalg.eigvalsh(held[:, 3:, 3:])[:, 0] / np.linalg.eigvalsh(inertia)[:, 0]
        for number in self.rows[np.minimum(share, turning) < LEAST_HELD][:1]:
            raise CaseError(
                f"particles.{number} meets no points of the grid that could move and turn it; a "
                f"free body must be some cells across."
            )
        mass_factor, spin_factor = (
            np.where(lack > 0.0, flat * np.maximum(1.0, lack / part) ** 3, 0.0)
            for part in (share, turning)
        )
        self._take_virtual(-excess * mass_factor, -spin_factor[:, None, None] * excess_inertia)

    def _take_virtual(self, mass: np.ndarray, inertia: np.ndarray) -> None:
        self._virtual, self._virtual_inertia = mass, inertia
        self._mass, self._inertia = self._excess[0] + mass, self._excess[1] + inertia
        # Of an impulse's moment, what the body's own inertia has at first: C has the rest.
        own = self._own_inertia
        self._own_share = own @ np.linalg.inv(own + inertia)

    def _kick(self, scheme: Scheme) -> np.ndarray:
        """γΣJ − Σα_q ΣJ of the levels before: the whole of an impulse shows at once in V.

        As a force over one step it would reach V in parts, with several-step schemes.
        """
        kick, left = np.zeros((self.rows.size, 6)), scheme.gamma
        for weight, impulse in zip((*scheme.past, 0.0), self.contact_impulses, strict=False):
            kick += left * impulse
            left -= weight
        return kick

    def _system_of(self, turn: np.ndarray, scheme: Scheme, rate: float, matrix) -> np.ndarray:
        """(m,6,6): inertia beyond the displaced fluid's, and what the impulse takes."""
        system = rate * matrix[self.rows]
        system[:, :3, :3] += scheme.gamma * self._mass[:, None, None] * np.eye(3)
        system[:, 3:, 3:] += scheme.gamma * _turned(turn, self._inertia)
        return system

    def _turn(self, state: BodyState, spin: np.ndarray, dt: float) -> np.ndarray:
        """Quaternions (m,4) Δt later; spin (n,3) now. What contact gave goes into no torque."""
        torque = (self.past_turning[0] - self.past_turning[-1]) / dt
        if len(self.past_turning) > 1:
            share = _turned(state.rotation[self.rows], self._own_share)
            torque -= (share @ self.contact_impulses[0][:, 3:, None])[..., 0] / dt
        quaternion, spin = state.quaternion[self.rows], spin[self.rows]
        return advance_rotation(quaternion, spin, self._own_inertia, torque, dt)[0]


def _flatness(inertia: np.ndarray) -> np.ndarray:
    """(2/(3−3n))³ within 1 and 125, n the largest depolarisation factor of an equal ellipsoid.

    Equal in its inertia. The added mass is n/(1−n) of the displaced: flat bodies need a larger C
    than spheres do, 11 times at n = .7, by the roots of an inviscid step.
    """
    moments = np.linalg.eigvalsh(inertia)
    moments = moments / moments.sum(axis=1, keepdims=True)
    squares = 1.0 - 2.0 * moments
    n = np.sqrt(squares.prod(axis=1)) / 3.0 * elliprd(*squares.T)
    return np.clip(2.0 / (3.0 - 3.0 * n), 1.0, 5.0) ** 3


def _turned(turn: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    """R T Rᵀ of each body."""
    return turn @ tensor @ np.swapaxes(turn, 1, 2)

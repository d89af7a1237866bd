"""Bodies that move freely: Newton and Euler, solved together with the impulse.

    M a = F + W,   F = ρVa − (ργ/Δt)∫f dV,   f = φ(u_p − uˢ)            (F as in `loads.py`)
    ⇒ (M − ρV + C)(γVⁿ⁺¹ − Σα_q Vⁿ⁻q) + ργ∫φ(u_pⁿ⁺¹ − uˢ)dV = WΔt + C aⁿΔt

and so for the moments about the centre of mass, with L = R J Rᵀ Ω in place of V. The impulse is
linear in (V, Ω), so that each body is one 6×6 system, whatever its density. What the fluid gains
the bodies lose, to round-off, as long as C = 0.

C is a virtual mass: a body lighter than its fluid is solved as if neutrally buoyant, the rest of
its inertia taken from the step before. Without it the pressure, which answers an acceleration one
step late, would make light bodies unstable: |M_a − C| < M + C must hold, M_a the added mass.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.contact import Contact, ContactHistory, driven
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.schemes import Scheme

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
        self._mass = np.maximum(excess, 0.0) * volume
        self._virtual = np.maximum(-excess, 0.0) * volume
        self._inertia = np.maximum(excess, 0.0)[:, None, None] * inertia
        self._virtual_inertia = np.maximum(-excess, 0.0)[:, None, None] * inertia
        weight = (excess * volume)[:, None] * free.gravity
        self.loads = np.concatenate([free.force + weight, free.torque], axis=1)
        # What a checkpoint holds besides the bodies' own state, newest level first.
        self.past_spin: list[np.ndarray] = []
        self.change = np.zeros((free.rows.size, 6))
        self.contact_history = ContactHistory.none(displaced.volume.size)
        self.contact_impulse = np.zeros((free.rows.size, 6))

    def place(self, state: BodyState, past: list, time: float, since: float) -> None:
        """Rⁿ⁺¹ = Rⁿ + Δt(3Vⁿ − Vⁿ⁻¹)/2 + contact, and so for the turn; past[0] is level n."""
        if not self.rows.size:
            return
        dt, history = time - since, self.contact_history
        newer, older = past[0], past[1] if len(past) > 1 else past[0]
        gains = (history.velocity_gain, history.spin_gain)
        velocity, spin = (driven(*levels, dt) for levels in zip(newer, older, gains, strict=True))
        walls = self._wall_velocity(0.5 * (time + since))
        moved = self.contact.move(state.position, state.quaternion, velocity, spin, dt, walls)
        state.position[self.rows] = moved.position[self.rows]
        state.quaternion[self.rows] = moved.quaternion[self.rows]
        self.contact_history = moved.history
        self.contact_impulse = np.concatenate([moved.impulse, moved.angular_impulse], axis=1)[
            self.rows
        ]

    def remember(self, state: BodyState, levels: int) -> None:
        """Keep the angular momenta of the level that is about to become old."""
        self.past_spin.insert(0, self._spin(state))
        del self.past_spin[levels:]

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
        known += rate * momentum[rows] + dt * self.loads + self.contact_impulse
        turn = state.rotation[rows]
        known[:, :3] += self._virtual[:, None] * self.change[:, :3]
        virtual = _turned(turn, self._virtual_inertia)
        known[:, 3:] += np.einsum("nij,nj->ni", virtual, self.change[:, 3:])
        found = np.linalg.solve(self._system(turn, scheme, rate, matrix), known[..., None])
        state.velocity[rows], state.angular_velocity[rows] = found[:, :3, 0], found[:, 3:, 0]

    def response(self, state: BodyState, scheme: Scheme, matrix, momentum) -> np.ndarray:
        """(n,6): what velocities change by when the ∫φuˢ and ∫r×φuˢ change by `momentum` (n,6)."""
        gain = np.zeros((state.count, 6))
        if self.rows.size:
            rate = self.density * scheme.gamma
            system = self._system(state.rotation[self.rows], scheme, rate, matrix)
            right = rate * momentum[self.rows]
            gain[self.rows] = np.linalg.solve(system, right[..., None])[..., 0]
        return gain

    def note_change(self, change: list) -> None:
        """Keep Δt·(dV/dt, dΩ/dt) of the step just taken for the virtual mass of the next."""
        self.change = np.concatenate([c[self.rows] for c in change], axis=1)

    def _system(self, turn: np.ndarray, scheme: Scheme, rate: float, matrix) -> np.ndarray:
        """(m,6,6): inertia beyond the displaced fluid's, and what the impulse takes."""
        system = rate * matrix[self.rows]
        system[:, :3, :3] += scheme.gamma * self._mass[:, None, None] * np.eye(3)
        system[:, 3:, 3:] += scheme.gamma * _turned(turn, self._inertia)
        return system

    def _spin(self, state: BodyState) -> np.ndarray:
        inertia = _turned(state.rotation[self.rows], self._inertia)
        return np.einsum("nij,nj->ni", inertia, state.angular_velocity[self.rows])


def _turned(turn: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    """R T Rᵀ of each body."""
    return np.einsum("nij,njk,nlk->nil", turn, tensor, turn)

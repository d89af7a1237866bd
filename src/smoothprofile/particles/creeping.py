"""All bodies of a flow without inertia, behind their verbs: move, feel, take.

    Rⁿ⁺¹ = Rⁿ + Δt(Vⁿ + ½(Δt/Δt')(Vⁿ − Vⁿ⁻¹)) + contact       Δt' the step before
    qⁿ⁺¹ = exp(Δt(Ωⁿ + ½(Δt/Δt')(Ωⁿ − Ωⁿ⁻¹))) qⁿ

The Adams–Bashforth rule: of second order with one Stokes solve a step, but for contact, whose mean
force of a step is felt in the next (see `contact_creep.py`). V here is without what contact gave.
"""

from dataclasses import dataclass, field

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.contact_creep import CreepingContact
from smoothprofile.particles.dynamics import FreeBodies, WallVelocity
from smoothprofile.particles.motion import PrescribedMotion
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.particles import Pull, no_pull
from smoothprofile.particles.stress import stresslets


@dataclass
class FreeLoads:
    """What acts on free bodies: rows (m,), the loads that stay (m,6), and those that change.

    pulls, contact_impulses: of the last step alone, (m,6) each; wall_impulse (axis, side, 3).
    """

    rows: np.ndarray
    constant: np.ndarray
    pulls: list[np.ndarray] = field(default_factory=list)
    contact_impulses: list[np.ndarray] = field(default_factory=list)
    wall_impulse: np.ndarray = field(default_factory=lambda: np.zeros((3, 2, 3)))

    @classmethod
    def of(cls, free: FreeBodies, volume: np.ndarray, density: float) -> "FreeLoads":
        """F + (ρ_p − ρ)Vg and T of each; volume (n,) of all bodies, density ρ of the fluid."""
        weight = ((free.density - density) * volume[free.rows])[:, None] * free.gravity
        constant = np.concatenate([free.force + weight, free.torque], axis=1)
        return cls(free.rows, constant, [np.zeros_like(constant)], [np.zeros_like(constant)])


class CreepingBodies:
    """Bodies, how they move and what pulls them. No bodies at all is a valid instance."""

    def __init__(
        self,
        state: BodyState,
        motion: PrescribedMotion,
        free: FreeLoads,
        painter: Painter,
        contact: CreepingContact,
        wall_velocity: WallVelocity,
        pull: Pull = no_pull,
    ):
        self.state, self.motion, self.painter, self.free = state, motion, painter, free
        self.contact, self.pull, self._wall_velocity = contact, pull, wall_velocity
        self.held = ~np.isin(np.arange(state.count), free.rows)
        # V − w̄ and Ω − w̄_r (n,3) at this level and the one before, and the step between them.
        self.own = (np.zeros((state.count, 3)), np.zeros((state.count, 3)))
        self.pushed = (np.zeros((state.count, 3)), np.zeros((state.count, 3)))
        self.before: tuple[np.ndarray, np.ndarray] | None = None
        self.step = 0.0
        self.first_moment = np.zeros((state.count, 3, 3))
        painter.paint(state)

    def move(self, time: float, since: float) -> None:
        """To where the bodies are at `time`."""
        state, rows, dt = self.state, self.free.rows, time - since
        here, turned = state.position.copy(), state.quaternion.copy()
        spin = state.angular_velocity.copy()
        self.motion.place(state, time, since)
        linear, angular = self._courses(dt)
        given = self.held
        linear[0][given] = (state.position - here)[given] / dt
        angular[0][given] = 0.5 * (state.angular_velocity + spin)[given]
        walls = self._wall_velocity(0.5 * (time + since))
        moved = self.contact.move(here, turned, linear, angular, dt, walls)
        state.position[rows] = moved.position[rows]
        state.quaternion[rows] = moved.quaternion[rows]
        impulse = np.concatenate([moved.impulse, moved.angular_impulse], axis=1)[rows]
        self.free.contact_impulses, self.free.wall_impulse = [impulse], moved.wall_impulse
        shift = (moved.position - here) / dt - linear[0]
        turn = self.contact.angular[:, None] * moved.angular_impulse / dt
        self.pushed = shift * ~given[:, None], turn
        self.before, self.step = self.own, dt

    def feel(self, time: float) -> None:
        """Take the loads that act on the bodies from afar, where they are now."""
        self.free.pulls = [self.pull(self.state, time)[self.free.rows]]

    def loads(self) -> tuple[np.ndarray, np.ndarray]:
        """F and T (n,3) on the free bodies, those of contact too; zero for the others."""
        found = np.zeros((self.state.count, 6))
        found[self.free.rows] = self.free.constant + self.free.pulls[0] + self._contact()
        return found[:, :3], found[:, 3:]

    def take(self, velocity, spin, force, torque, first_moment) -> None:
        """The motion that was found, and the loads by the fluid, (n,3) each; ∫r_i f_j dV."""
        state = self.state
        state.velocity[:], state.angular_velocity[:] = velocity, spin
        state.force[:], state.torque[:] = force, torque
        self.first_moment = first_moment
        self.own = velocity - self.pushed[0], spin - self.pushed[1]

    def stresslets(self) -> np.ndarray:
        """S = −dev sym ∫r_i f_j dV (n,3,3), f of the bodies on the fluid; zero before any flow."""
        return stresslets(self.first_moment, np.zeros_like(self.first_moment), 1.0, 1.0)

    def saved(self) -> dict:
        """Everything that the next step reads, for a checkpoint taken between steps."""
        return {
            "state": self.state.saved(),
            "own": self.own,
            "before": self.before,
            "pushed": self.pushed,
            "step": self.step,
            "first_moment": self.first_moment,
            "pulls": self.free.pulls,
            "contact_impulses": self.free.contact_impulses,
            "wall_impulse": self.free.wall_impulse,
        }

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave, and paint the bodies there."""
        self.state.restore(saved["state"])
        self.own, self.pushed = tuple(saved["own"]), tuple(saved["pushed"])
        before = saved["before"]
        self.before = None if before is None else tuple(before)
        self.step, self.first_moment = saved["step"], saved["first_moment"]
        self.free.pulls = list(saved["pulls"])
        self.free.contact_impulses = list(saved["contact_impulses"])
        self.free.wall_impulse = saved["wall_impulse"]
        self.painter.paint(self.state)

    def _contact(self) -> np.ndarray:
        """F̄ and T̄ (m,6) over the step before."""
        impulse = self.free.contact_impulses[0]
        return impulse / self.step if self.step else impulse

    def _courses(self, dt: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """V̄ and V̇, Ω̄ and Ω̇ over the step."""
        if self.before is None:
            return [(now.copy(), np.zeros_like(now)) for now in self.own]
        rates = [(n - b) / self.step for n, b in zip(self.own, self.before, strict=True)]
        return [
            (n + 0.5 * dt * rate, rate * ~self.held[:, None])
            for n, rate in zip(self.own, rates, strict=True)
        ]

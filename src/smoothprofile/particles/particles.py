"""All bodies of a run, behind four verbs: move, paint, impose, and the mean they will cause."""

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.particles.loads import Impulse
from smoothprofile.particles.motion import PrescribedMotion
from smoothprofile.particles.paint import Painter
from smoothprofile.schemes import Scheme


class Particles:
    """Bodies, how they move, how they are painted. No bodies at all is a valid instance."""

    def __init__(
        self,
        state: BodyState,
        motion: PrescribedMotion,
        painter: Painter,
        impulse: Impulse,
        density: float,
    ):
        """density: that of the fluid."""
        self.state, self.motion, self.painter, self.impulse = state, motion, painter, impulse
        self.density = density
        self.past_velocity: list[tuple[np.ndarray, np.ndarray]] = []
        painter.paint(state)
        self.displaced = DisplacedFluid.of(painter, state)

    def move(self, time: float, since: float, levels: int) -> None:
        """To where the bodies are at `time`; `levels` past velocities are kept for the loads."""
        state = self.state
        self.past_velocity.insert(0, (state.velocity.copy(), state.angular_velocity.copy()))
        del self.past_velocity[levels:]
        self.motion.place(state, time, since)

    def paint(self) -> None:
        self.painter.paint(self.state)

    def impose(self, velocity: tuple, scheme: Scheme, dt: float) -> None:
        """u ← u + φ(u_p − u), and the loads on the bodies."""
        state, rate = self.state, scheme.gamma / dt
        inertia = self.displaced.loads(state, *self._accelerations(scheme, rate))
        gained = self.impulse.impose(self.painter, state, velocity)
        for load, needed, gain in zip((state.force, state.torque), inertia, gained, strict=True):
            load[:] = self.density * (needed - rate * gain)

    def added_mean(self, field: np.ndarray, component: int, is_velocity: bool) -> float:
        """What `impose` would add to the mean of that velocity component."""
        return self.impulse.solid_mean(self.painter, self.state, field, component, is_velocity)

    def _accelerations(self, scheme: Scheme, rate: float) -> list[np.ndarray]:
        """dV/dt and dΩ/dt by the scheme's own difference (γVⁿ⁺¹ − Σα_q Vⁿ⁻q)/Δt."""
        change = [self.state.velocity.copy(), self.state.angular_velocity.copy()]
        for weight, past in zip(scheme.past, self.past_velocity, strict=False):
            for c, old in zip(change, past, strict=True):
                c -= weight / scheme.gamma * old
        return [rate * c for c in change]

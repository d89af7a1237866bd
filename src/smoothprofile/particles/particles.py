"""All bodies of a run, behind five verbs: move, paint, settle, impose, and the mean they cause."""

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.dynamics import FreeMotion
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
        free: FreeMotion,
        displaced: DisplacedFluid,
        painter: Painter,
        impulse: Impulse,
        density: float,
    ):
        """displaced, density: of the fluid."""
        self.state, self.motion, self.painter, self.impulse = state, motion, painter, impulse
        self.density = density
        self.past_velocity: list[tuple[np.ndarray, np.ndarray]] = []
        self.free, self.displaced = free, displaced
        painter.paint(state)

    def move(self, time: float, since: float, levels: int) -> None:
        """To where the bodies are at `time`; `levels` past velocities are kept for the loads."""
        state = self.state
        self.past_velocity.insert(0, (state.velocity.copy(), state.angular_velocity.copy()))
        self.free.remember(state, levels)
        self.free.place(state, self.past_velocity, time, since)
        self.motion.place(state, time, since)
        # Free bodies are placed from two levels, whatever the scheme.
        del self.past_velocity[max(levels, 2) :]

    def paint(self) -> None:
        self.painter.paint(self.state)

    def settle(self, velocity: tuple, scheme: Scheme, dt: float) -> None:
        """Find the velocities of free bodies that the impulse on this fluid will leave them."""
        if not self.free.rows.size:
            return
        self._matrix, momentum = self.impulse.momenta(self.painter, self.state, velocity)
        past = self.past_velocity
        self.free.solve(self.state, past, scheme, dt, self._matrix, momentum)
        self._scheme = scheme

    def impose(self, velocity: tuple, scheme: Scheme, dt: float) -> None:
        """u ← u + φ(u_p − u), and the loads on the bodies."""
        state, rate = self.state, scheme.gamma / dt
        change = self._changes(scheme)
        inertia = self.displaced.loads(state, *(rate * c for c in change))
        gained = self.impulse.impose(self.painter, state, velocity)
        for load, needed, gain in zip((state.force, state.torque), inertia, gained, strict=True):
            load[:] = self.density * (needed - rate * gain)
        self.free.note_change([scheme.gamma * c for c in change])

    def added_mean(self, field: np.ndarray, component: int, is_velocity: bool) -> float:
        """What `impose` would add to the mean of that velocity component.

        Of a response, a field that is added to the fluid's velocity, with what it adds to the
        velocity of free bodies.
        """
        state = self.state
        motion = (state.velocity, state.angular_velocity)
        if not is_velocity:
            motion = self._response_motion(field, component)
        return self.impulse.solid_mean(self.painter, state, motion, field, component)

    def _response_motion(self, field: np.ndarray, component: int) -> tuple:
        gain = np.zeros((self.state.count, 6))
        if self.free.rows.size:
            nothing = np.broadcast_to(np.zeros((), field.dtype), field.shape)
            fields = tuple(field if c == component else nothing for c in range(3))
            _, momentum = self.impulse.momenta(self.painter, self.state, fields)
            gain = self.free.response(self.state, self._scheme, self._matrix, momentum)
        return gain[:, :3], gain[:, 3:]

    def _changes(self, scheme: Scheme) -> list[np.ndarray]:
        """Vⁿ⁺¹ − Σα_q Vⁿ⁻q/γ and the same of Ω: γ/Δt of it is the scheme's own derivative."""
        change = [self.state.velocity.copy(), self.state.angular_velocity.copy()]
        for weight, past in zip(scheme.past, self.past_velocity, strict=False):
            for c, old in zip(change, past, strict=True):
                c -= weight / scheme.gamma * old
        return change

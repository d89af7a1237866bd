"""All bodies of a run, behind four verbs: move, paint, impose, and the mean they will cause."""

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.loads import Impulse
from smoothprofile.particles.motion import PrescribedMotion
from smoothprofile.particles.paint import Painter
from smoothprofile.schemes import Scheme


class Particles:
    """Bodies, how they move, how they are painted. No bodies at all is a valid instance."""

    def __init__(
        self, state: BodyState, motion: PrescribedMotion, painter: Painter, impulse: Impulse
    ):
        self.state, self.motion, self.painter, self.impulse = state, motion, painter, impulse
        self.past_velocity: list[tuple[np.ndarray, np.ndarray]] = []
        painter.paint(state)
        self.displaced = self._true_over_painted_volume()

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
        change = self._velocity_change(scheme)
        self.impulse.impose(
            self.painter, self.state, change, self.displaced, velocity, scheme.gamma / dt
        )

    def added_mean(self, field: np.ndarray, component: int, is_velocity: bool) -> float:
        """What `impose` would add to the mean of that velocity component."""
        return self.impulse.solid_mean(self.painter, self.state, field, component, is_velocity)

    def _true_over_painted_volume(self) -> np.ndarray:
        """(n,) the volume that each body displaces over the one it is painted with.

        Of a body without end both are what lies in the box, the first without offsets.
        """
        painted, volume = self.impulse.volumes(self.painter, self.state), self.painter.forms.volume
        endless = np.isinf(volume)
        if endless.any():
            true = self.painter.without_offsets()
            true.paint(self.state)
            volume = np.where(endless, self.impulse.volumes(true, self.state), volume)
        return volume / painted

    def _velocity_change(self, scheme: Scheme) -> tuple[np.ndarray, np.ndarray]:
        change = [self.state.velocity.copy(), self.state.angular_velocity.copy()]
        for weight, past in zip(scheme.past, self.past_velocity, strict=False):
            for c, old in zip(change, past, strict=True):
                c -= weight / scheme.gamma * old
        return change[0], change[1]

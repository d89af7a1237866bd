"""Motion that is given: held bodies, constants and sinusoids, or any function of time.

    R(t) = R₀ + ∫V dt,   q(t+Δt) = exp(∫Ω dt) q(t)

The rotation of a step is exact when the direction of Ω does not change during it, and of second
order in Δt otherwise.
"""

from collections.abc import Callable, Sequence

import numpy as np

from smoothprofile import rotations
from smoothprofile.particles.bodies import BodyState
from smoothprofile.signals import Signal

Course = Callable[[float], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
"""t -> (position, quaternion, velocity, angular velocity)."""


class PrescribedMotion:
    """Velocities of all bodies as signals (held ones have zero), with courses for some of them."""

    def __init__(
        self,
        state: BodyState,
        velocity: Sequence[Signal],
        angular_velocity: Sequence[Signal],
        courses: dict[int, Course] | None = None,
        time: float = 0.0,
        free: Sequence[int] = (),
    ):
        """free: rows whose motion is not given; their signals are those of the start."""
        self._velocity, self._spin = _Signals(velocity), _Signals(angular_velocity)
        self._courses = dict(courses or {})
        self._origin = state.position - self._velocity.integral(time)
        self._given = np.setdiff1d(np.arange(state.count), np.asarray(free, dtype=np.int64))
        state.velocity[:] = self._velocity.at(time)
        state.angular_velocity[:] = self._spin.at(time)
        self.place(state, time, time)

    def place(self, state: BodyState, time: float, since: float) -> None:
        """Put the bodies, known at time `since`, where they are at `time`."""
        given = self._given
        state.position[given] = (self._origin + self._velocity.integral(time))[given]
        state.velocity[given] = self._velocity.at(time)[given]
        state.angular_velocity[given] = self._spin.at(time)[given]
        turn = (self._spin.integral(time) - self._spin.integral(since))[given]
        turned = rotations.multiply(rotations.from_vector(turn), state.quaternion[given])
        state.quaternion[given] = turned
        for b, course in self._courses.items():
            position, quaternion, velocity, spin = course(time)
            state.position[b], state.quaternion[b] = position, quaternion
            state.velocity[b], state.angular_velocity[b] = velocity, spin


class _Signals:
    """Signals of many bodies, evaluated together."""

    def __init__(self, signals: Sequence[Signal]):
        self._constant = np.array([s.constant for s in signals], dtype=np.float64).reshape(-1, 3)
        self._amplitude = np.array([s.amplitude for s in signals], dtype=np.float64).reshape(-1, 3)
        self._omega = np.array([s.angular_frequency for s in signals], dtype=np.float64)
        self._phase = np.array([s.phase for s in signals], dtype=np.float64)

    def at(self, time: float) -> np.ndarray:
        wave = np.cos(self._omega * time + self._phase)
        return self._constant + wave[:, None] * self._amplitude

    def integral(self, time: float) -> np.ndarray:
        half = 0.5 * self._omega * time
        wave = time * np.sinc(half / np.pi) * np.cos(half + self._phase)
        return time * self._constant + wave[:, None] * self._amplitude

"""All bodies of a run, behind their verbs: move, feel, paint, settle, impose."""

from collections.abc import Callable

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.dynamics import FreeMotion
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.particles.loads import Impulse, vectors
from smoothprofile.particles.motion import PrescribedMotion
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.stress import displaced_moments, stresslets
from smoothprofile.schemes import Scheme

Pull = Callable[[BodyState, float], np.ndarray]
"""(state, time) -> force and torque on each body, (n,6), along the box's axes."""


def no_pull(state: BodyState, time: float) -> np.ndarray:
    """Nothing acts from afar."""
    return np.zeros((state.count, 6))


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
        pull: Pull = no_pull,
    ):
        """displaced, density: of the fluid. pull: what else acts on bodies where they are."""
        self.state, self.motion, self.painter, self.impulse = state, motion, painter, impulse
        self.density, self.pull = density, pull
        self.past_velocity: list[tuple[np.ndarray, np.ndarray]] = []
        self.free, self.displaced = free, displaced
        self._rate, self._change = 0.0, None
        # Moments of φu of the velocity that the bodies last settled in, until it is imposed upon.
        self._fluid: np.ndarray | None = None
        painter.paint(state)
        if free.rows.size:
            free.learn(impulse.matrix(painter))

    def move(self, time: float, since: float, levels: int) -> None:
        """To where the bodies are at `time`; `levels` past velocities are kept for the loads."""
        state = self.state
        self.past_velocity.insert(0, (state.velocity.copy(), state.angular_velocity.copy()))
        self.free.remember(state, levels)
        self.free.place(state, self.past_velocity, time, since)
        self.motion.place(state, time, since)
        # Free bodies are placed from two levels, whatever the scheme.
        del self.past_velocity[max(levels, 2) :]

    def carry(self, velocity: tuple) -> float:
        """u ← u + φ(u_p − u) before any step; the largest ∫|f| dV or ∫|r×f| dV of a body."""
        gained = self.impulse.impose(self.painter, self.state, velocity)
        return max(float(np.abs(gain).max(initial=0.0)) for gain in gained)

    def feel(self, time: float) -> None:
        """Take the loads that act on the bodies from afar, where they are now."""
        self.free.feel(self.pull(self.state, time))

    def paint(self) -> None:
        self.painter.paint(self.state)
        self._fluid = None

    def settle(self, velocity: tuple, scheme: Scheme, dt: float) -> None:
        """Find the velocities of free bodies that the impulse on this fluid will leave them."""
        fields = dict(enumerate(velocity))
        self._fluid = self.impulse.fluid_moments(self.painter, self.state.count, fields)
        self._responses: dict[int, tuple] = {}
        if self.free.rows.size:
            matrix = self.impulse.matrix(self.painter)
            momentum = self.impulse.momentum(self.painter, self._fluid)
            self.free.solve(self.state, self.past_velocity, scheme, dt, matrix, momentum)

    def settle_with(self, force: np.ndarray) -> None:
        """Add `force` (3,) times the responses that `added_mean` has seen."""
        for component, (fluid, gain) in self._responses.items():
            self._fluid += force[component] * fluid
            self.state.velocity += force[component] * gain[:, :3]
            self.state.angular_velocity += force[component] * gain[:, 3:]
        self._responses = {}

    def impose(self, velocity: tuple, scheme: Scheme, dt: float) -> None:
        """u ← u + φ(u_p − u), and the loads on the bodies."""
        state, rate = self.state, scheme.gamma / dt
        change = self._changes(scheme)
        inertia = self.displaced.loads(state, *(rate * c for c in change))
        gained = self.impulse.impose(self.painter, state, velocity, self._fluid)
        self._fluid = None
        for load, needed, gain in zip((state.force, state.torque), inertia, gained, strict=True):
            load[:] = self.density * (needed - rate * gain)
        self._rate, self._change = rate, change

    def given(self) -> tuple[np.ndarray, np.ndarray]:
        """Force and torque (n,3) on the fluid, that inside too, over the step just taken."""
        inside = self.displaced.loads(self.state, *(self._rate * c for c in self._change))
        loads = (self.state.force, self.state.torque)
        return tuple(self.density * i - load for i, load in zip(inside, loads, strict=True))

    def saved(self) -> dict:
        """Everything that the next step reads, for a checkpoint taken between steps."""
        return {
            "state": self.state.saved(),
            "past_velocity": self.past_velocity,
            "free": self.free.saved(),
        }

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave, and paint the bodies there."""
        self.state.restore(saved["state"])
        self.past_velocity = [tuple(level) for level in saved["past_velocity"]]
        self.free.restore(saved["free"])
        self.paint()

    def stresslets(self) -> np.ndarray:
        """(n,3,3) of the step just taken; zero before the first."""
        if self._change is None:
            return np.zeros((self.state.count, 3, 3))
        needed = displaced_moments(
            self.displaced, self.state, *(self._rate * c for c in self._change)
        )
        gained = self.impulse.first_moments(self.painter, self.state)
        return stresslets(gained, needed, self._rate, self.density)

    def added_mean(self, field: np.ndarray, component: int, is_velocity: bool) -> float:
        """What `impose` would add to the mean of that velocity component.

        Of the velocity that the bodies settled in; or of a response, what a uniform force adds to
        it, with what that adds to the velocity of free bodies.
        """
        if is_velocity:
            motion = (self.state.velocity, self.state.angular_velocity)
            return self.impulse.solid_mean(self.painter, motion, self._fluid, component)
        fluid = self._moments_of_response(field, component)
        gain = self.free.response(vectors(fluid))
        self._responses[component] = fluid, gain
        motion = gain[:, :3], gain[:, 3:]
        return self.impulse.solid_mean(self.painter, motion, fluid, component, response=True)

    def _moments_of_response(self, field: np.ndarray, component: int) -> np.ndarray:
        count, sums = self.state.count, self.painter.sums
        if not all(self.painter.grid.periodic):
            return self.impulse.fluid_moments(self.painter, count, {component: field})
        # Without walls a uniform force moves all fluid alike.
        fluid = np.zeros((count, 3, 4))
        fluid[:, component] = float(field[1, 1, 1]) * sums[:, component, :4]
        return fluid

    def _changes(self, scheme: Scheme) -> list[np.ndarray]:
        """Vⁿ⁺¹ − Σα_q Vⁿ⁻q/γ and the same of Ω: γ/Δt of it is the scheme's own derivative."""
        change = [self.state.velocity.copy(), self.state.angular_velocity.copy()]
        for weight, past in zip(scheme.past, self.past_velocity, strict=False):
            for c, old in zip(change, past, strict=True):
                c -= weight / scheme.gamma * old
        return change

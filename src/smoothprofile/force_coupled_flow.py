"""Spheres in a flow with inertia by the force coupling method: nothing is painted.

    predict   uˢ without the spheres
    settle    F = W − (m_p − m_f) dV/dt,   T = T_ext − (I_p − I_f) dΩ/dt,   E = 0
    force     u** = uˢ + (1 − c∇²)⁻¹ (Δt/γρ)Σ(F Δ_M − D·∇Δ_D),   c = θνΔt/γ
    project   uⁿ⁺¹, of which V, Ω and E of each sphere are averages over its envelopes

m_f and I_f are those of the fluid inside, which moves with the sphere. What a step answers to F, T
and S is linear, symmetric and positive definite, so that all loads of a step are found together by
conjugate gradients; each round spreads, solves as a step does, and gathers. A sphere lighter than
the fluid takes its inertia from the step before.

Lomholt & Maxey, J. Comput. Phys. 184 (2003); Lomholt, Stenum & Maxey, Int. J. Multiphase Flow 28
(2002).
"""

from dataclasses import dataclass, field

import numpy as np

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.errors import CaseError
from smoothprofile.flow.advance import Flow, Step
from smoothprofile.flow.state import FlowState, zero_velocity
from smoothprofile.flow.viscosity import Viscosity
from smoothprofile.schemes import Scheme
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.viscous.force_coupling_envelopes import Envelopes
from smoothprofile.viscous.force_coupling_moments import (
    Scale,
    conjugate_gradients,
    lone_resistance,
    moments_of,
    power,
    spin,
    strain,
)

_AT_REST = ((0.0, 0.0),) * 3


@dataclass(frozen=True, eq=False)
class Spheres:
    """radius and density (n,), force and torque (n,3) on each, gravity (3,) on what exceeds ρ_f."""

    radius: np.ndarray
    density: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    gravity: np.ndarray

    @classmethod
    def of(cls, radius, density, force=0.0, torque=0.0, gravity=(0.0, 0.0, 0.0)) -> "Spheres":
        """radius (n,); the rest are broadcast to it."""
        radius = np.atleast_1d(np.asarray(radius, dtype=np.float64))
        for name, values in (("radius", radius), ("density", np.asarray(density))):
            if not (np.isfinite(values).all() and np.all(values > 0.0)):
                raise CaseError(f"{name} of a sphere must be a number above 0.")
        rows = (radius.size, 3)
        return cls(
            radius,
            np.broadcast_to(np.asarray(density, dtype=np.float64), radius.shape),
            np.broadcast_to(np.asarray(force, dtype=np.float64), rows),
            np.broadcast_to(np.asarray(torque, dtype=np.float64), rows),
            np.asarray(gravity, dtype=np.float64),
        )


@dataclass
class SphereMotion:
    """What changes in time: (n,3) each but the stresslet (n,3,3), and the older levels of V and Ω.

    force and torque are those on the fluid; `change` are dV/dt and dΩ/dt of the last step.
    """

    position: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    stresslet: np.ndarray
    change: tuple[np.ndarray, np.ndarray]
    past: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)


class ForceCoupledFlow:
    """Marches spheres and a flow together; the flow's own step knows nothing of them."""

    def __init__(
        self,
        flow: Flow,
        state: FlowState,
        spheres: Spheres,
        position: np.ndarray,
        *,
        rigid: bool = True,
        tolerance: float = 1e-4,
        limit: int = 200,
    ):
        """rigid = False leaves the stresslets out. Spheres start with the velocity of the fluid.

        tolerance: √ of the power of what is left of E and of Newton's equation, over the total.
        """
        self.flow, self.state, self.spheres, self.rigid = flow, state, spheres, rigid
        self.tolerance, self.limit = tolerance, limit
        self.envelopes = Envelopes(flow.grid, flow.boundaries, spheres.radius)
        self._viscosity = tuple(Viscosity(flow.grid, b) for b in flow.boundaries)
        self._scratch = zero_velocity(flow.grid)
        excess = spheres.density - flow.parameters.density
        volume = 4.0 / 3.0 * np.pi * spheres.radius**3
        self.excess = excess * volume, 0.4 * excess * volume * spheres.radius**2
        self.load = spheres.force + (excess * volume)[:, None] * spheres.gravity
        position = np.array(position, dtype=np.float64).reshape(-1, 3)
        if position.shape[0] != self.envelopes.count:
            raise CaseError(
                f"position has {position.shape[0]} rows; there are {self.envelopes.count} spheres."
            )
        zero = np.zeros_like(position)
        self.motion = SphereMotion(
            position, zero, zero, zero, zero, np.zeros((*zero.shape, 3)), (zero, zero)
        )
        self.envelopes.place(position)
        self._read_motion()

    def step(self, dt: float) -> SolveReport:
        """Advance spheres and fluid by dt, always the same; how the solve for the loads ended."""
        flow, state, motion = self.flow, self.state, self.motion
        self._move(dt)
        self.envelopes.place(motion.position)
        step = flow.predict(state, dt)
        problem = _Loads.of(self, step)
        moments, report = self._settle(step, problem)
        flow.measure_walls(state, step)
        flow.hold_mean(step)
        flow.project(state, step)
        flow.finish(state, step)
        motion.force = moments[:, :, 0].copy()
        motion.torque = 2.0 * spin(moments)
        motion.stresslet = -strain(moments)
        motion.past.insert(0, (motion.velocity, motion.angular_velocity))
        del motion.past[max(flow.parameters.scheme.levels, 2) :]
        self._read_motion()
        motion.change = self._derivative(step.scheme, dt)
        return report

    def _settle(self, step: Step, problem: "_Loads") -> tuple[np.ndarray, SolveReport]:
        """Find the loads and add to the step's velocity what they do to it before projection."""
        guess = problem.guess
        moments = problem.known - problem.scale(guess)
        self._force(step, moments)
        for add, u in zip(self._scratch, step.velocity, strict=True):
            u += add
            add[...] = u
        motion = self._projected(step, is_velocity=True)
        free = Scale(1.0, 1.0, 0.0)

        def operator(change: np.ndarray) -> np.ndarray:
            self._force(step, problem.scale(change))
            return free(change) + problem.scale(self._projected(step, is_velocity=False))

        solved = guess.copy()
        report = conjugate_gradients(
            operator,
            problem.precondition,
            solved,
            problem.scale(motion) - free(guess),
            reference=np.sqrt(power(problem.lone(motion), motion)),
            tolerance=self.tolerance,
            limit=self.limit,
        )
        change = problem.scale(solved - guess)
        if report.iterations:
            self._force(step, -change)
            for add, u in zip(self._scratch, step.velocity, strict=True):
                u += add
        return moments - change, report

    def _force(self, step: Step, moments: np.ndarray) -> None:
        """scratch ← (1 − c∇²)⁻¹ (Δt/γρ)Σ(F Δ_M − D·∇Δ_D)."""
        parameters = self.flow.parameters
        for f in self._scratch:
            f[...] = 0.0
        self.envelopes.spread(moments / (parameters.density * step.rate), self._scratch)
        implicit = step.scheme.implicit * parameters.kinematic_viscosity / step.rate
        for viscosity, f in zip(self._viscosity, self._scratch, strict=True):
            viscosity.solve(f, implicit, _AT_REST)

    def _projected(self, step: Step, is_velocity: bool) -> np.ndarray:
        """V and G of the scratch field after its mean is held and its divergence removed."""
        flow, field = self.flow, self._scratch
        held = flow.mean_flow

        def change_of_mean(values: np.ndarray, axis: int, is_field: bool) -> float:
            plain = held.plain_mean(values, axis, is_field)
            return plain + (held.targets[axis] if is_field else 0.0)

        held.hold(field, None if is_velocity else change_of_mean)
        if is_velocity:
            flow.fill(field, step.time)
        else:
            for f, boundary in zip(field, flow.boundaries, strict=True):
                fill_ghosts(f, boundary)
        flow.projection.make_divergence_free(field)
        return self.envelopes.gather(field)

    def _move(self, dt: float) -> None:
        """Yⁿ⁺¹ = Yⁿ + Δt(3Vⁿ − Vⁿ⁻¹)/2."""
        motion = self.motion
        older = motion.past[0][0] if motion.past else motion.velocity
        motion.position = motion.position + dt * (1.5 * motion.velocity - 0.5 * older)

    def _read_motion(self) -> None:
        found = self.envelopes.gather(self.state.velocity)
        self.motion.velocity, self.motion.angular_velocity = found[:, :, 0].copy(), spin(found)

    def _derivative(self, scheme: Scheme, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """(γVⁿ⁺¹ − Σα_q Vⁿ⁻q)/Δt, and of Ω."""
        motion = self.motion
        rates = [scheme.gamma * v for v in (motion.velocity, motion.angular_velocity)]
        for weight, level in zip(scheme.past, motion.past, strict=False):
            rates = [rate - weight * old for rate, old in zip(rates, level, strict=True)]
        return rates[0] / dt, rates[1] / dt


@dataclass(frozen=True, eq=False)
class _Loads:
    """q = b − Bz, (I' + BAB)z = B(V₀ + Ab): the loads q of one step, B = √K, K = m'γ/Δt.

    A is what a step answers; I' is 1 for forces and torques, 0 for stresslets, for which B = 1 and
    b = 0; b are the loads without the inertia of Vⁿ⁺¹.
    """

    known: np.ndarray
    scale: Scale
    lone: Scale
    precondition: Scale
    guess: np.ndarray

    @classmethod
    def of(cls, coupled: ForceCoupledFlow, step: Step) -> "_Loads":
        motion, spheres, scheme = coupled.motion, coupled.spheres, step.scheme
        levels = [(motion.velocity, motion.angular_velocity), *motion.past]
        loads, stiffness = [coupled.load, spheres.torque], []
        for part, excess in enumerate(coupled.excess):
            heavy, light = np.maximum(excess, 0.0), np.minimum(excess, 0.0)
            loads[part] = loads[part] - light[:, None] * motion.change[part]
            for weight, level in zip(scheme.past, levels, strict=False):
                loads[part] = loads[part] + (weight / step.dt * heavy)[:, None] * level[part]
            stiffness.append(heavy * step.rate)
        parameters, rigid = coupled.flow.parameters, float(coupled.rigid)
        lone = lone_resistance(
            spheres.radius,
            scheme.implicit * parameters.viscosity,
            step.rate * parameters.density,
        )
        # The dipole of a torque is half of it, in each of two places.
        stiffness[1] = 0.5 * stiffness[1]
        roots = [np.sqrt(stiff) for stiff in stiffness]
        guess = moments_of(
            roots[0][:, None] * motion.velocity,
            2.0 * roots[1][:, None] * motion.angular_velocity,
            -motion.stresslet,
        )
        return cls(
            known=moments_of(*loads, np.zeros_like(motion.stresslet)),
            scale=Scale(*roots, rigid),
            lone=lone,
            precondition=Scale(
                1.0 / (1.0 + stiffness[0] / lone.force),
                1.0 / (1.0 + stiffness[1] / lone.torque),
                rigid * lone.stresslet,
            ),
            guess=guess,
        )

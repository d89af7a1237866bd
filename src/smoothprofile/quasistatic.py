"""Suspensions without inertia: at every instant bodies and fluid move as their loads make them.

move       Rⁿ⁺¹, qⁿ⁺¹ from V, Ω of this level and the one before, and contact
feel       F = (ρ_p − ρ)Vg + given + electric + F̄ of contact, and T, where bodies are then
find       −∇p − G + μ∇²u + f = 0,  ∇·u = 0,  u = V + Ω×r in bodies,
           ∫f dV = F of free bodies, V and Ω of the others as given:  u, V, Ω, p, G

Inertia would show as Re = ρUa/μ; bodies take a²ρ/μ to come to the speed that is found here at once.
"""

from dataclasses import asdict, dataclass

import numpy as np

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.errors import BlowUpError
from smoothprofile.flow.monitor import Extremes
from smoothprofile.flow.state import FlowState
from smoothprofile.flow.walls import Walls, pressure_forces, viscous_forces
from smoothprofile.grid import Grid, interior
from smoothprofile.particles.creeping import CreepingBodies
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.staggered import volume_mean
from smoothprofile.viscous.stokes import RigidStokes


def advance(flow: "QuasiStaticFlow", bodies: CreepingBodies, state: FlowState, dt: float) -> None:
    """One step, with one Stokes solve, at its end."""
    bodies.move(state.time + dt, state.time)
    bodies.feel(state.time + dt)
    flow.find(bodies, state, state.time + dt)
    state.steps += 1


def set_out(flow: "QuasiStaticFlow", bodies: CreepingBodies, state: FlowState) -> None:
    """The flow at the start."""
    bodies.feel(state.time)
    flow.find(bodies, state, state.time)
    # From no flow at all to this one is no change of it.
    flow.extremes = Extremes(flow.extremes.speed)


@dataclass(frozen=True)
class Drive:
    """What drives the fluid besides bodies; mean_velocity None where body_force drives instead."""

    walls: Walls
    body_force: tuple[float, float, float]
    mean_velocity: tuple[float | None, float | None, float | None]


class QuasiStaticFlow:
    """The fluid around the bodies of one run; the last flow starts the next solve."""

    def __init__(self, stokes: RigidStokes, drive: Drive, tolerance: float):
        self.grid, self.stokes, self.drive, self.tolerance = stokes.grid, stokes, drive, tolerance
        self._weight = _weight(self.grid, drive.body_force)
        self.extremes = Extremes()
        self.report: SolveReport | None = None
        self.pressure_gradient = np.zeros(3)

    def find(self, bodies: CreepingBodies, state: FlowState, time: float) -> None:
        """The flow at that time and what it makes of the bodies; BlowUpError if there is none."""
        force, torque = bodies.loads()
        found = self.stokes.solve(
            bodies.state,
            bodies.held,
            velocity=bodies.state.velocity,
            spin=bodies.state.angular_velocity,
            force=force,
            torque=torque,
            mean_velocity=self.drive.mean_velocity,
            # A uniform force b on all there is, is a gradient −b of the pressure.
            pressure_gradient=-np.array(self.drive.body_force),
            wall_velocity=self.drive.walls.velocities(time),
            tolerance=self.tolerance,
            warm=True,
        )
        self.report, self.pressure_gradient = found.report, found.pressure_gradient
        self._check(time)
        bodies.take(found.velocity, found.spin, found.force, found.torque, found.first_moment)
        self._show(state, time)

    def wall_force(self, state: FlowState) -> dict[str, np.ndarray]:
        """Force of the fluid on each wall (3,)."""
        walls, mu = self.drive.walls, self.stokes.viscosity
        sheared = viscous_forces(self.grid, walls, state.velocity, mu, state.time)
        pressed = pressure_forces(self.grid, state.pressure, 1.0, self.drive.body_force)
        return {name: force + pressed[name] for name, force in sheared.items()}

    def mean_velocity(self, state: FlowState) -> list[float]:
        """⟨u⟩ of fluid and bodies together."""
        return [volume_mean(self.grid, field, c) for c, field in enumerate(state.velocity)]

    def largest_divergence(self, state: FlowState) -> float:
        """max |∇·u|."""
        return self.stokes.direct.largest_divergence(state.velocity, self.grid.zeros())

    def saved(self) -> dict:
        """What a warm start needs besides the state, and what is told of the last solve."""
        return {
            "last": self.stokes.last,
            "report": self.report and asdict(self.report),
            "pressure_gradient": self.pressure_gradient,
            "speed": self.extremes.speed,
            "change": self.extremes.change,
        }

    def restore(self, saved: dict, state: FlowState) -> None:
        """Take back what `saved` gave, for a state that has been restored."""
        last = saved["last"]
        self.stokes.recall(state.velocity, last and tuple(last))
        self.report = saved["report"] and SolveReport(**saved["report"])
        self.pressure_gradient = saved["pressure_gradient"]
        self.extremes = Extremes(tuple(saved["speed"]), tuple(saved["change"]))

    def _check(self, time: float) -> None:
        report = self.report
        if not report.converged:
            raise BlowUpError(
                f"the flow did not converge at t = {time:.6g}: {report.status} after "
                f"{report.iterations} iterations, at a residual of {report.residual:.3g} against "
                f"fluid.tolerance = {self.tolerance:g}."
            )

    def _show(self, state: FlowState, time: float) -> None:
        """The flow that was found, its ghosts with it, and its extremes."""
        speed, change = [], []
        for new, field in zip(self.stokes.velocity, state.velocity, strict=True):
            change.append(float(np.abs(interior(new) - interior(field)).max()))
            field[...] = new
            speed.append(float(np.abs(interior(field)).max()))
        self.extremes = Extremes(tuple(speed), tuple(change))
        state.pressure[...] = self.stokes.pressure
        for line in self._weight:
            state.pressure += line
        fill_ghosts(state.pressure, pressure_boundary(self.grid))
        state.time = time


def _weight(grid: Grid, force: tuple[float, float, float]) -> list[np.ndarray]:
    """b·x, of zero mean, along each walled axis: there pressure alone bears a uniform force b."""
    lines = []
    for d, axis in enumerate(grid.axes):
        if not axis.periodic and force[d]:
            from_middle = axis.padded_centres - 0.5 * (axis.low + axis.high)
            lines.append(force[d] * from_middle.reshape([-1 if k == d else 1 for k in range(3)]))
    return lines

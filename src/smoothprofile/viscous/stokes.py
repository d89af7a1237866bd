"""Steady Stokes flow around rigid bodies: the resistance and the mobility problem of all at once.

    −∇p − G + μ∇²u + f = 0,   ∇·u = 0,   f = Σ_b χ_b (V_b + Ω_b×r − u),   χ_b = (μ/ℓ²) φ_b

With f = √χ g and u = U + 𝒮f, 𝒮 the direct Stokes solve of zero mean flow, this is

    K g = √χ (u_b − U),   K = 1 + √χ 𝒮 √χ + Z m Zᵀ:

symmetric and positive definite; Z m Zᵀ is what `calibration.stokes` gives a sphere besides. Where
V, Ω are not given but the load F, T on a body is, its g has to obey ∫f dV = F, ∫r×f dV = T, and
V, Ω are what keeps it there; so, too, a mean flow U that is not given where G is. All are solved
for in one iteration, preconditioned by 1 − √χ(𝒮⁻¹ + μ/ℓ²)⁻¹√χ, the inverse inside large bodies,
so that the number of iterations hardly depends on how many bodies there are.

No-slip walls are layers too, one cell thick, in a box that slips; see `no_slip`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from smoothprofile.boundaries import fill_ghosts, velocity_boundary
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.loads import vectors
from smoothprofile.particles.paint import Painter
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.viscous.balance import NOTHING_MOVES, Balance, Drive
from smoothprofile.viscous.direct import DirectStokes, Vector
from smoothprofile.viscous.iteration import constrained_conjugate_gradients, norm
from smoothprofile.viscous.layers import BodyLayers
from smoothprofile.viscous.no_slip import WallLayers

TOLERANCE = 1e-6
MOST_ITERATIONS = 500
HELD_MEAN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class StokesMotion:
    """What a solve found. All (n,3), along the box's axes, about the bodies' positions.

    velocity, spin: V, Ω; force, torque: on the bodies by the fluid, −∫f dV and −∫r×f dV;
    first_moment (n,3,3): ∫r_i f_j dV. mean_velocity: U, pressure_gradient: G (3,) of the box.
    wall_force (3,2,3): on the walls by the fluid, along them, by axis, side and component.
    """

    velocity: np.ndarray
    spin: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    first_moment: np.ndarray
    mean_velocity: np.ndarray
    pressure_gradient: np.ndarray
    wall_force: np.ndarray
    report: SolveReport


class RigidStokes:
    """Solves for the flow around one painter's bodies; `velocity`, `pressure` are its fields."""

    def __init__(
        self,
        grid: Grid,
        painter: Painter,
        viscosity: float,
        layer: float,
        compliance: np.ndarray | None = None,
        walls: Sequence = (("wall", "wall"),) * 3,
    ):
        """layer: ℓ, how deep fluid enters a body. compliance (n,3): of translation, rotation and
        strain, over the viscosity, nothing if left out. walls[axis]: (low, high) of "wall" or
        "slip" where the axis is not periodic.
        """
        if grid.dtype != np.float64:
            raise CaseError('domain.precision must be "double" for steady Stokes flow.')
        self.grid, self.viscosity, self.layer = grid, float(viscosity), float(layer)
        self.direct = DirectStokes(grid, viscosity)
        self.bodies = BodyLayers(painter, viscosity / layer**2, compliance, viscosity)
        self.walls = WallLayers(grid, self.direct, walls)
        self.velocity: Vector = tuple(grid.zeros() for _ in range(3))
        self.pressure = grid.zeros()
        self._work: Vector = tuple(grid.zeros() for _ in range(3))
        self._last: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def resistance(self, state: BodyState, velocity, spin, **options) -> StokesMotion:
        """The loads on bodies that all move as given: V, Ω (n,3). Options as for `solve`."""
        held = np.ones(state.count, dtype=bool)
        return self.solve(state, held, velocity=velocity, spin=spin, **options)

    def mobility(self, state: BodyState, force, torque, **options) -> StokesMotion:
        """The motion of free bodies under loads F, T (n,3). Options as for `solve`."""
        held = np.zeros(state.count, dtype=bool)
        return self.solve(state, held, force=force, torque=torque, **options)

    def solve(
        self,
        state: BodyState,
        held: np.ndarray,
        *,
        velocity=0.0,
        spin=0.0,
        force=0.0,
        torque=0.0,
        mean_velocity: Sequence[float | None] = HELD_MEAN,
        pressure_gradient: Sequence[float] = HELD_MEAN,
        wall_velocity: np.ndarray = NOTHING_MOVES,
        gradient: np.ndarray | None = None,
        body_force: Vector | None = None,
        tolerance: float = TOLERANCE,
        limit: int = MOST_ITERATIONS,
        warm: bool = False,
    ) -> StokesMotion:
        """Bodies at `state`: those `held` (n,) move with V, Ω given, the others are pulled by F, T.

        mean_velocity: U along each periodic axis, or None where G is `pressure_gradient` instead.
        wall_velocity (3,2,3), by axis, side and component; normal ones are zero. gradient (3,3):
        E_ij = ∂u_i/∂x_j of a linear flow that is not part of u; V, Ω and U then are what bodies
        and fluid have besides, V + E·R in all. body_force: padded fields of a force density on the
        fluid. tolerance: of the residual in √χu, over that of the bodies' motion. warm: start from
        the flow found last. CaseError where what is given does not determine the flow.
        """
        self.bodies.paint(state)
        drive = Drive(mean_velocity, pressure_gradient, np.asarray(wall_velocity), gradient)
        given = _rows(state, velocity, spin), _rows(state, force, torque)
        driven = self._driven(body_force)
        balance = Balance(self.bodies, self.walls, np.asarray(held, bool), drive, *given, driven[1])
        known = balance.known(driven[0])
        g = balance.start(self._guess(balance) if warm else None)
        residual = np.empty_like(g)
        self._apply(g, residual)
        np.subtract(known, residual, out=residual)
        reference = max(norm(known), norm(residual))
        balance.project(residual)
        report = constrained_conjugate_gradients(
            self._apply,
            self._precondition,
            balance.project,
            g,
            residual,
            reference=reference,
            tolerance=tolerance,
            limit=limit,
        )
        return self._finish(balance, g, known, body_force, report)

    @property
    def last(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """What `warm` starts from besides `velocity`: V, Ω and moments; None before any solve."""
        return self._last

    def recall(self, velocity: Vector, last: tuple | None) -> None:
        """Take back a flow that was found, and `last`: a warm solve then has the same bits."""
        for own, old in zip(self.velocity, velocity, strict=True):
            own[...] = old
        self._last = last

    def _driven(self, body_force: Vector | None) -> tuple:
        """𝒮f of a body force, None if there is none, and its mean (3,)."""
        if body_force is None:
            return None, np.zeros(3)
        for field, given in zip(self._work, body_force, strict=True):
            field[...] = given
        mean = self.direct.solve(self._work, self._work, self.pressure)
        return self._work, mean

    def _apply(self, g: np.ndarray, out: np.ndarray) -> np.ndarray:
        """out = K g; returns the mean force ⟨f⟩ (3,). Leaves 𝒮f in the work fields."""
        self._clear()
        mean = self._add_flow_of(g, self._work)
        (bodies, walls), (out_bodies, out_walls) = self._parts(g), self._parts(out)
        self.bodies.gather(self._work, bodies, out_bodies)
        self.bodies.comply(bodies, out_bodies)
        self.walls.gather(self._work, walls, out_walls)
        return mean

    def _precondition(self, r: np.ndarray, out: np.ndarray) -> None:
        """out = (1 − √χ(𝒮⁻¹ + μ/ℓ²)⁻¹√χ) r for bodies; for walls the inverse of their own part."""
        (bodies, walls), (out_bodies, out_walls) = self._parts(r), self._parts(out)
        self._clear()
        self.bodies.spread(bodies, self._work)
        self.direct.solve(self._work, self._work, self.pressure, None, self.bodies.resistance)
        self.bodies.gather(self._work, bodies, out_bodies, -1.0)
        self.walls.precondition(walls, out_walls)

    def _parts(self, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return g[: self.bodies.size], g[self.bodies.size :]

    def _clear(self) -> None:
        for field in self._work:
            field[...] = 0.0

    def _add_flow_of(self, g: np.ndarray, fields: Vector) -> np.ndarray:
        """From a force density in `fields` to its flow and that of g there; the mean force (3,)."""
        bodies, walls = self._parts(g)
        self.bodies.spread(bodies, fields)
        self.walls.spread(walls, fields)
        return self.direct.solve(fields, fields, self.pressure)

    def _guess(self, balance: Balance) -> np.ndarray | None:
        """g = √χ(u_b − u) with the flow and the motion found last."""
        if self._last is None or self._last[0].shape[0] != self.bodies.count:
            return None
        return balance.guess(self.velocity, *self._last)

    def _finish(self, balance: Balance, g, known, body_force, report) -> StokesMotion:
        residual = np.empty_like(g)
        pressure_gradient = self._apply(g, residual)
        np.subtract(known, residual, out=residual)
        velocity, spin, mean_velocity = balance.found(residual)
        bodies, walls = self._parts(g)
        moments = self.bodies.moments(bodies)
        self._last = velocity, spin, moments
        self.velocity, self._work = self._work, self.velocity
        if body_force is not None:
            for field, given in zip(self.velocity, body_force, strict=True):
                field[...] = given
            pressure_gradient = self._add_flow_of(g, self.velocity)
        for c, (u, mean) in enumerate(zip(self.velocity, mean_velocity, strict=True)):
            u += mean
            boundary = velocity_boundary(self.grid, self.walls.kinds, c)
            fill_ghosts(u, boundary, balance.drive.wall_velocity[:, :, c])
        moments = self.bodies.cell * moments
        load = vectors(moments)
        return StokesMotion(
            velocity=velocity,
            spin=spin,
            force=-load[:, :3],
            torque=-load[:, 3:],
            first_moment=np.swapaxes(moments[:, :, 1:], 1, 2),
            mean_velocity=mean_velocity,
            pressure_gradient=pressure_gradient,
            wall_force=-self.walls.forces(walls),
            report=report,
        )


def _rows(state: BodyState, linear, angular) -> np.ndarray:
    """(n,6) of what is given for all bodies or for each."""
    parts = [np.broadcast_to(np.asarray(a, float), (state.count, 3)) for a in (linear, angular)]
    return np.concatenate(parts, axis=1)

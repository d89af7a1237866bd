"""What is given and what is sought in one Stokes solve: known velocities, loads, constraints.

    K g = b + Zλ + Wκ,   Zᵀg = (F, T)/v,   Wᵀg = (Gv_box − ΣF − ∫f_b dV)/v

b holds the known velocities √χ(V + Ω×r − U − E·r) of held bodies and walls, Z the rigid motions of
free bodies, λ = (V − U, Ω) of theirs; W a uniform motion of all that is not free, along the axes
whose mean flow is sought, κ = −U. v: of a cell. Z and W are orthogonal, body by body.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.particles.loads import vectors
from smoothprofile.particles.stress import cross_matrix
from smoothprofile.viscous.layers import BodyLayers
from smoothprofile.viscous.no_slip import WallLayers

NOTHING_MOVES = np.zeros((3, 2, 3))
NOTHING_MOVES.flags.writeable = False


@dataclass(frozen=True, eq=False)
class Drive:
    """What drives the flow besides bodies, as in `RigidStokes.solve`."""

    mean_velocity: Sequence[float | None]
    pressure_gradient: Sequence[float]
    wall_velocity: np.ndarray
    gradient: np.ndarray | None


class Balance:
    """The right-hand side and the constraints of one solve."""

    def __init__(
        self,
        bodies: BodyLayers,
        walls: WallLayers,
        held: np.ndarray,
        drive: Drive,
        motion: np.ndarray,
        load: np.ndarray,
        mean_force: np.ndarray,
    ):
        """held (n,); motion, load (n,6); mean_force (3,): of what acts on the fluid besides."""
        self.bodies, self.walls, self.held, self.drive = bodies, walls, held, drive
        grid = bodies.painter.grid
        self.motion, self.load = motion * held[:, None], load * ~held[:, None]
        periodic = np.array(grid.periodic)
        self.open = np.array([U is None for U in drive.mean_velocity]) & periodic
        self.mean = np.array([0.0 if U is None else float(U) for U in drive.mean_velocity])
        if np.any(self.mean[~periodic]):
            raise CaseError(
                "fluid.mean_velocity must be zero or left out along an axis that ends in walls."
            )
        self.inverse = bodies.inverse * np.where(held, 0.0, 1.0)[:, None, None]
        self.fixed = bodies.totals * held[:, None]
        self.weight = self.fixed.sum(axis=0) + walls.totals
        pulled = np.asarray(drive.pressure_gradient, float) - mean_force
        self.total = pulled * grid.volume / bodies.cell - self.load[:, :3].sum(axis=0) / bodies.cell
        for axis in np.flatnonzero(self.open & (self.weight == 0.0)):
            raise CaseError(
                f"fluid.mean_velocity.{'xyz'[axis]} must be given: no wall and no held body is "
                f"there to hold the fluid."
            )

    @property
    def size(self) -> int:
        return self.bodies.size + self.walls.size

    def known(self, driven: tuple | None) -> np.ndarray:
        """b; driven: the flow 𝒮f_b of the force on the fluid."""
        b = np.zeros(self.size)
        bodies, walls = self._parts(b)
        if driven is not None:
            self.bodies.gather(driven, bodies, bodies, -1.0)
            self.walls.gather(driven, walls, walls, -1.0)
        velocity = self.motion[:, :3] - self.mean * self.held[:, None]
        slope = cross_matrix(self.motion[:, 3:])
        if self.drive.gradient is not None:
            slope = slope - self.drive.gradient
        self.bodies.add_linear(bodies, velocity, slope)
        self.walls.add_uniform(walls, self.drive.wall_velocity - self.mean)
        return b

    def start(self, guess: np.ndarray | None) -> np.ndarray:
        """A g that obeys the constraints, as near to `guess` as can be."""
        g = np.zeros(self.size) if guess is None else guess
        self._correct(g, self.load / self.bodies.cell, self.total)
        return g

    def guess(
        self, flow: tuple, velocity: np.ndarray, spin: np.ndarray, moments: np.ndarray
    ) -> np.ndarray:
        """√χ(u_b − u) of a flow, of V, Ω (n,3), which those given overrule, and of g's moments."""
        g = np.zeros(self.size)
        bodies, walls = self._parts(g)
        motion = np.concatenate([velocity, spin], axis=1)
        motion = np.where(self.held[:, None], self.motion, motion)
        yielding, slope = self.bodies.yielding(moments)
        slope = cross_matrix(motion[:, 3:]) - slope
        if self.drive.gradient is not None:
            slope = slope - self.drive.gradient
        self.bodies.gather(flow, bodies, bodies, -1.0)
        self.bodies.add_linear(bodies, motion[:, :3] - yielding, slope)
        self.walls.gather(flow, walls, walls, -1.0)
        self.walls.add_uniform(walls, self.drive.wall_velocity)
        return g

    def project(self, r: np.ndarray) -> None:
        """r ← r − Z(ZᵀZ)⁻¹Zᵀr − W(WᵀW)⁻¹Wᵀr."""
        self._correct(r, np.zeros_like(self.load), np.zeros(3))

    def motion_of(self, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """−λ (n,6) of the free bodies and −κ (3,), from b − Kg."""
        bodies, walls = self._parts(residual)
        moments = self.bodies.moments(bodies)
        return self._rigid(vectors(moments)), self._uniform(moments, walls)

    def found(self, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """V, Ω (n,3) of all bodies and U (3,), from b − Kg."""
        lacking, mean = self.motion_of(residual)
        mean = np.where(self.open, mean, self.mean)
        found = -lacking
        found[:, :3] += mean
        motion = np.where(self.held[:, None], self.motion, found)
        return motion[:, :3].copy(), motion[:, 3:].copy(), mean

    def _correct(self, g: np.ndarray, load: np.ndarray, total: np.ndarray) -> None:
        bodies, walls = self._parts(g)
        moments = self.bodies.moments(bodies)
        motion = self._rigid(load - vectors(moments))
        if self.open.any():
            lacking = total / np.where(self.weight > 0.0, self.weight, 1.0) * self.open
            uniform = lacking - self._uniform(moments, walls)
            motion[:, :3] += uniform * self.held[:, None]
            self.walls.add_uniform(walls, np.broadcast_to(uniform, (3, 2, 3)))
        velocity = np.ascontiguousarray(motion[:, :3])
        self.bodies.add_linear(bodies, velocity, cross_matrix(motion[:, 3:]))

    def _rigid(self, moments: np.ndarray) -> np.ndarray:
        """(ZᵀZ)⁻¹ of (n,6)."""
        return np.einsum("nij,nj->ni", self.inverse, moments)

    def _uniform(self, moments: np.ndarray, walls: np.ndarray) -> np.ndarray:
        """(WᵀW)⁻¹Wᵀ (3,), zero along axes whose mean is given."""
        if not self.open.any():
            return np.zeros(3)
        sums = moments[self.held, :, 0].sum(axis=0) + self.walls.sums(walls).sum(axis=(0, 1))
        return np.where(self.open, sums / np.where(self.weight > 0.0, self.weight, 1.0), 0.0)

    def _parts(self, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return g[: self.bodies.size], g[self.bodies.size :]

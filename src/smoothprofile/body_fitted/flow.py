"""Steady flow past a sphere at rest: Taylor–Hood elements, Newton's method.

    ρ(u·∇)u = −∇p + μ∇²u + g e_x,    ∇·u = 0

u of degree k and p of degree k − 1, both continuous. The Stokes part is factorised once; Newton's
method starts from Stokes flow, and GMRES solves its linear problems with that factor as
preconditioner, at Re = 10 in some ten iterations.
"""

from dataclasses import dataclass

import ngsolve as ng
import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from smoothprofile.errors import BlowUpError

COMPRESSIBLE = 1e-9
"""∇·u = −10⁻⁹p/μ in the factorised matrix, for nothing else sets the mean of p and the elimination
does not pivot; the iterations drive the rest of ∇·u to zero."""
CONVERGED, MOST_STEPS = 1e-8, 20
"""Residual over the first one, and Newton steps: four or five are enough."""
LINEAR, KRYLOV = 1e-2, 100
"""Reduction by each GMRES, and the most iterations: more than Newton's next step gains is lost."""


@dataclass(frozen=True, eq=False)
class SteadyFlow:
    """velocity, pressure  functions of place on the mesh
    reaction            x-force of the fluid on the part of the sphere that the mesh has
    steps, residual     Newton steps, and what they left of the first residual
    """

    velocity: ng.CoefficientFunction
    pressure: ng.CoefficientFunction
    reaction: float
    steps: int
    residual: float


class FiniteElements:
    """The discrete problem on a mesh with the boundaries of meshes.py, u of degree `order`."""

    def __init__(self, mesh: ng.Mesh, order: int, viscosity: float = 1.0):
        closed = {"x": "sphere|wall", "y": "sphere|wall|y|end", "z": "sphere|wall|z|end"}
        speeds = [ng.Periodic(ng.H1(mesh, order=order, dirichlet=name)) for name in closed.values()]
        self.mesh, self.order, self.viscosity = mesh, order, viscosity
        self.space = ng.FESpace([*speeds, ng.Periodic(ng.H1(mesh, order=order - 1))])
        self._inside = ng.Projector(self.space.FreeDofs(), True)
        self._unit = self._held("sphere", 1.0)
        stokes = ng.BilinearForm(self._stokes_form(COMPRESSIBLE), symmetric=True).Assemble()
        self._inverse = stokes.mat.Inverse(self.space.FreeDofs(), inverse="sparsecholesky")

    @property
    def unknowns(self) -> int:
        """How many values of u and p the discrete problem has, with those given on boundaries."""
        return self.space.ndof

    def solve(
        self, density: float = 0.0, wall_speed: float = 0.0, body_force: float = 0.0
    ) -> SteadyFlow:
        """The steady flow between walls that slide at `wall_speed` along x, driven by g.

        density: ρ; 0 is Stokes flow. BlowUpError if Newton's method does not converge.

        The reaction is −⟨residual, w⟩ for any w of the space that is e_x on the sphere and 0 on
        walls: ∫ρ(u·∇)u·w + μ∇u:∇w − p∇·w − g w_x. It is as accurate as the energy of the flow,
        where the stress itself, integrated over the surface, would lose an order or more.
        """
        found = self._held("wall", wall_speed)
        outcome = self._newton(found, self._equations(0.0, body_force))
        if density:
            outcome = self._newton(found, self._equations(density, body_force))
        *speeds, pressure = found.components
        return SteadyFlow(ng.CF(tuple(speeds)), pressure, *outcome)

    def _newton(
        self, found: ng.GridFunction, equations: ng.BilinearForm
    ) -> tuple[float, int, float]:
        """Improve `found` until it solves the equations: reaction, steps and relative residual."""
        residual, free = found.vec.CreateVector(), found.vec.CreateVector()
        first = size = 0.0
        for step in range(MOST_STEPS + 1):
            equations.Apply(found.vec, residual)
            free.data = self._inside * residual
            size = ng.Norm(free)
            first = first or size
            if size <= CONVERGED * first:
                return -ng.InnerProduct(residual, self._unit.vec), step, size / first
            equations.AssembleLinearization(found.vec)
            found.vec.data -= self._correction(equations.mat, free)
        raise BlowUpError(
            f"Newton's method left {size / first:.1e} of the residual after {MOST_STEPS} steps, "
            f"more than {CONVERGED}: the Reynolds number is too high for it."
        )

    def _equations(self, density: float, body_force: float) -> ng.BilinearForm:
        (*u, _), (*v, _) = self.space.TnT()
        form = ng.BilinearForm(self._stokes_form(0.0))
        if density:
            speed, gradient = ng.CF(tuple(u)), ng.CF(tuple(map(ng.grad, u)), dims=(3, 3))
            form += density * (gradient * speed) * ng.CF(tuple(v)) * ng.dx
        if body_force:
            form += -body_force * v[0] * ng.dx
        return form

    def _stokes_form(self, compressible: float):
        (*u, p), (*v, q) = self.space.TnT()
        shear = sum(ng.grad(a) * ng.grad(b) for a, b in zip(u, v, strict=True))
        flux = sum(
            ng.grad(a)[i] * q + ng.grad(b)[i] * p for i, (a, b) in enumerate(zip(u, v, strict=True))
        )
        mu = self.viscosity
        return (mu * shear - flux - compressible / mu * p * q) * ng.dx

    def _held(self, boundary: str, speed: float) -> ng.GridFunction:
        """u_x = speed on a boundary, everything else zero."""
        found = ng.GridFunction(self.space)
        found.components[0].Set(ng.CF(speed), definedon=self.mesh.Boundaries(boundary))
        return found

    def _correction(self, matrix, right) -> ng.BaseVector:
        """Newton's correction: matrix·x = right, preconditioned from the right."""
        given, solved = right.CreateVector(), right.CreateVector()

        def apply(values: np.ndarray) -> np.ndarray:
            given.FV().NumPy()[:] = values
            solved.data = self._inverse * given
            given.data = matrix * solved
            solved.data = self._inside * given
            return solved.FV().NumPy().copy()

        operator = LinearOperator((self.unknowns,) * 2, matvec=apply, dtype=float)
        values = right.FV().NumPy().copy()
        given.FV().NumPy()[:] = gmres(operator, values, rtol=LINEAR, restart=KRYLOV, maxiter=1)[0]
        solved.data = self._inverse * given
        return solved

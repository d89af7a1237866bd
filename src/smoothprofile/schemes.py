"""Time schemes as tables of coefficients.

    (γ uˢ − Σ_q α_q uⁿ⁻q)/Δt + Σ_q β_q N(uⁿ⁻q) = ν∇²[θ uˢ + (1−θ) uⁿ] − ∇pⁿ + g

α, β run from the newest level back. θ = 1 is fully implicit viscosity, θ = ½ Crank–Nicolson.
The tables know nothing of a grid, so that the calibration, which needs γ and θ, can read them.

Sources: backward Euler is the thesis' (2.6); the stiffly stable BDF tables are those of
Karniadakis, Israeli & Orszag, J. Comput. Phys. 97 (1991), used with the smoothed profile
method by Luo, Maxey & Karniadakis, J. Comput. Phys. 228 (2009).
"""

from dataclasses import dataclass

from smoothprofile.errors import CaseError


@dataclass(frozen=True)
class Scheme:
    """Coefficients of one scheme; `order` is its order of accuracy in time.

    `starts` are the schemes of the first steps, when 1, 2, … time levels are known. A `corrected`
    one takes its advection as the mean of N(uⁿ) and N of a trial step, which makes a single step
    accurate enough to start a scheme of third order.
    """

    name: str
    order: int
    gamma: float
    past: tuple[float, ...]
    advection: tuple[float, ...]
    implicit: float = 1.0
    starts: tuple["Scheme", ...] = ()
    corrected: bool = False

    @property
    def levels(self) -> int:
        """How many past velocities the scheme reads."""
        return max(len(self.past), len(self.advection))

    def with_levels(self, known: int) -> "Scheme":
        """The scheme for a step that has `known` time levels: itself, or one of its starts."""
        return self if known >= self.levels else self.starts[known - 1]


_EULER = Scheme("backward-euler", 1, 1.0, (1.0,), (1.0,))
_TRAPEZOID = Scheme("crank-nicolson", 1, 1.0, (1.0,), (1.0,), implicit=0.5)
_CORRECTED = Scheme("trapezoid", 2, 1.0, (1.0,), (1.0,), implicit=0.5, corrected=True)
_BDF2 = Scheme("bdf2", 2, 1.5, (2.0, -0.5), (2.0, -1.0), starts=(_EULER,))

SCHEMES = {
    scheme.name: scheme
    for scheme in (
        _EULER,
        Scheme("crank-nicolson", 2, 1.0, (1.0,), (1.5, -0.5), 0.5, starts=(_TRAPEZOID,)),
        _BDF2,
        Scheme("bdf3", 3, 11 / 6, (3.0, -1.5, 1 / 3), (3.0, -3.0, 1.0), starts=(_CORRECTED, _BDF2)),
    )
}


def scheme_named(name: str) -> Scheme:
    """The scheme of that name; CaseError with the list of names otherwise."""
    if name not in SCHEMES:
        raise CaseError(f"time.scheme is {name!r}; it must be one of {', '.join(SCHEMES)}.")
    return SCHEMES[name]

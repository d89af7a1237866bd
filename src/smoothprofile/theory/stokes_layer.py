"""The flow over a flat wall that oscillates in its own plane, by smoothed profile steps.

The wall is a slab 0 < y < h that moves with V = cos ωt; the fluid lies above it. One step is

    (γuˢ − Σ_q α_q uⁿ⁻q)/Δt = ν ∂²/∂y² [θuˢ + (1−θ)uⁿ],    uⁿ⁺¹ = uˢ + φ(Vⁿ⁺¹ − uˢ),

and the wall pushes the fluid with f = γφ(Vⁿ⁺¹ − uˢ)/Δt a unit of volume. Of ∫f dy the slab itself
takes what it needs to speed up; the rest is the stress on the fluid above it:

    τⁿ⁺¹ = ∫f dy − h(γVⁿ⁺¹ − Σ_q α_q Vⁿ⁻q)/Δt.

Density is one. Source: the thesis, section 3.2 and appendix A.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from smoothprofile.theory.collocation import solve_linear

GROWTH = 1.5
TANH_REACH = 10.0
FLOORS = ("free", "driven")


@dataclass(frozen=True)
class OscillatingWall:
    """The wall, its painted layer and the fluid.

    indicator          φ(z), z = (y − h)/ξ
    core, edge         φ = 1 for z ≤ core and 0 for z ≥ edge; infinite where it only tends to that
    thickness          ξ
    height             h, of the slab
    depth              of the fluid above it; its far boundary moves as the exact solution there
    angular_frequency  ω
    viscosity          ν, kinematic
    """

    indicator: Callable[[np.ndarray], np.ndarray]
    core: float
    edge: float
    thickness: float
    height: float = 3.0
    depth: float = 3.0
    angular_frequency: float = 1.0
    viscosity: float = 1.0

    @property
    def top(self) -> float:
        """y of the far boundary."""
        return self.height + self.depth

    @property
    def exact_response(self) -> complex:
        """√(ων) e^{iπ/4}: τ = Re of this times e^{iωt} is −√(ων) sin(ωt − π/4)."""
        return np.sqrt(self.angular_frequency * self.viscosity) * np.exp(0.25j * np.pi)

    def solid(self, y: np.ndarray) -> np.ndarray:
        """φ at y."""
        return self.indicator((y - self.height) / self.thickness)


@dataclass(frozen=True)
class Steps:
    """Δt and the table of a time scheme: γ, α from the newest level back, and θ."""

    step: float
    gamma: float = 1.0
    past: Sequence[float] = (1.0,)
    implicit: float = 1.0


@dataclass(frozen=True, eq=False)
class PeriodicFlow:
    """Complex amplitudes: each quantity is Re(amplitude·e^{iωtⁿ⁺¹}) at the end of a step.

    y          (e+1,) edges of the elements
    predicted  S of uˢ, (e+1,)
    corrected  U of uⁿ⁺¹, (e+1,)
    push       of ∫f dy
    stress     of τ
    """

    y: np.ndarray
    predicted: np.ndarray
    corrected: np.ndarray
    push: complex
    stress: complex


def exact_velocity(wall: OscillatingWall, y: np.ndarray, time: float) -> np.ndarray:
    """u = Re exp(Y + i(Y + ωt)), Y = √(ω/2ν)(h − y) for y > h; cos ωt in the slab. Thesis (3.8)."""
    depth = np.maximum(y - wall.height, 0.0)
    return np.real(_exact_wave(wall, depth) * np.exp(1j * wall.angular_frequency * time))


def exact_stress(wall: OscillatingWall, times: np.ndarray) -> np.ndarray:
    """τ = −√(ων) sin(ωt − π/4), the force of the wall on a unit area of the fluid."""
    return np.real(wall.exact_response * np.exp(1j * wall.angular_frequency * times))


def relative_errors(wall: OscillatingWall, response: complex) -> tuple[float, float]:
    """|c| − 1 and arg c of c = response/exact: amplitude error, and phase error in radians.

    A positive phase leads the exact stress.
    """
    ratio = response / wall.exact_response
    return float(abs(ratio) - 1.0), float(np.angle(ratio))


def layer_edges(wall: OscillatingWall) -> np.ndarray:
    """Edges of elements from 0 to the top: even across the painted layer, growing away from it.

    The ends of a compact profile are edges; a tanh counts as compact at |z| = 10, where it is
    within 2e-9 of its limit, and goes on beyond. ValueError if slab or fluid is thinner than that.
    """
    inner, outer = max(wall.core, -TANH_REACH), min(wall.edge, TANH_REACH)
    if wall.height <= -inner * wall.thickness or wall.depth <= outer * wall.thickness:
        raise ValueError(
            f"a layer of thickness {wall.thickness:g} does not fit into a slab {wall.height:g} "
            f"high under fluid {wall.depth:g} deep."
        )
    count = 6 if np.isfinite(wall.core) else 24
    across = wall.height + wall.thickness * np.linspace(inner, outer, count + 1)
    width = across[1] - across[0]
    below = across[0] - _growing(across[0], width)[::-1]
    above = across[-1] + _growing(wall.top - across[-1], width)
    return np.concatenate((below, across[1:], above[1:]))


def periodic_flow(wall: OscillatingWall, steps: Steps, floor: str = "free") -> PeriodicFlow:
    """The state in which every step repeats the last one but for a factor z = e^{iωΔt}.

    With A = Σ_q α_q z^{−q−1}, uˢ = Re S zⁿ⁺¹ and U = φ + (1−φ)S, viscosity acts on
    W = θS + (1−θ)U/z, which obeys

        νΔt W″ = γS − AU,    S = (W − eφ)/(θ + e(1−φ)),    e = (1−θ)/z.

    ∫f dy = (γ/Δt)∫φ(1−S)dy; what is solved for beside W is the part of it that vanishes inside a
    rigid slab, ∫φ(A − γS)dy/Δt, and ∫φ dy.

    floor: "free" for no stress at y = 0, so that the slab moves as one; "driven" for uˢ = V there,
    the thesis' condition, which leaves a layer of its own at y = 0: V changes during a step, and
    the predicted velocity in the slab is AV/γ.
    """
    if floor not in FLOORS:
        raise ValueError(f"floor is {floor!r}; it must be one of {', '.join(FLOORS)}.")
    turn = np.exp(1j * wall.angular_frequency * steps.step)
    past = sum(a * turn ** -(q + 1.0) for q, a in enumerate(steps.past))
    explicit = (1.0 - steps.implicit) / turn

    def parts(y):
        phi = wall.solid(y)
        # S = slope·W + offset
        slope = 1.0 / (steps.implicit + explicit * (1.0 - phi))
        return phi, slope, -explicit * phi * slope

    def matrix(y):
        phi, slope, offset = parts(y)
        bend = (steps.gamma - past * (1.0 - phi)) / (wall.viscosity * steps.step)
        rows = np.zeros((y.size, 8, 8))
        rows[:, 0, 2] = rows[:, 1, 3] = 1.0
        _place(rows, 2, bend * slope, bend * offset - past * phi / (wall.viscosity * steps.step))
        gain = phi / steps.step
        _place(rows, 4, -steps.gamma * gain * slope, gain * (past - steps.gamma * offset))
        rows[:, 6, 7] = phi
        return rows

    edges = layer_edges(wall)
    moved = steps.implicit + explicit
    far = _exact_wave(wall, wall.depth) * moved
    left, right = _ends(moved if floor == "driven" else None)
    found = solve_linear(matrix, edges, left, right, np.array([far.real, far.imag, 1.0]))
    phi, slope, offset = parts(edges)
    predicted = slope * (found[:, 0] + 1j * found[:, 1]) + offset
    excess, painted = found[-1, 4] + 1j * found[-1, 5], found[-1, 6]
    acceleration = (steps.gamma - past) / steps.step
    push = excess + painted * acceleration
    return PeriodicFlow(
        edges,
        predicted,
        predicted + phi * (1.0 - predicted),
        complex(push),
        complex(push - wall.height * acceleration),
    )


def fourier_coefficients(
    times: np.ndarray, stress: np.ndarray, angular_frequency: float, harmonics: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """a_n = (2/T)∫cos(nωt) τ dt and b_n = (2/T)∫sin(nωt) τ dt, n = 0 … harmonics; appendix A.

    times, stress: one whole period T = 2π/ω in equal steps, its end or its start left out. On
    such a period the sum over the steps is exact for every harmonic that the steps can tell apart.
    """
    turns = angular_frequency * np.arange(harmonics + 1)[:, None] * times
    share = 2.0 / times.size
    return share * np.cos(turns) @ stress, share * np.sin(turns) @ stress


def fitted_response(wall: OscillatingWall, times: np.ndarray, stress: np.ndarray) -> complex:
    """Appendix A's fit of a period of wall stress, as a response R: τ ≈ Re(R e^{iωt}).

    The phase of a₁cos ωt + b₁sin ωt before cos ωt is −arctan(b₁/a₁), π/4 for the exact stress τ₀,
    so that θ = −arctan(b₁/a₁) − π/4 is its lead over τ₀; the amplitude is then the projection
    (2/T)∫τ(t)τ₀(t + θ/ω)dt, τ₀ of unit amplitude. Arguments as in `fourier_coefficients`.
    """
    omega = wall.angular_frequency
    a, b = fourier_coefficients(times, stress, omega)
    lead = -np.arctan2(b[1], a[1]) - 0.25 * np.pi
    shifted = exact_stress(wall, times + lead / omega) / abs(wall.exact_response)
    amplitude = 2.0 / times.size * shifted @ stress
    return complex(amplitude * np.exp(1j * (lead + 0.25 * np.pi)))


def _exact_wave(wall: OscillatingWall, depth):
    """e^{−(1+i)√(ω/2ν)(y−h)}, depth = y − h."""
    return np.exp(-(1.0 + 1.0j) * np.sqrt(0.5 * wall.angular_frequency / wall.viscosity) * depth)


def _growing(length: float, width: float) -> np.ndarray:
    """Rising edges from 0 to `length`, the first width at most `width`, each next 1.5 times it."""
    count = max(1, int(np.ceil(np.log1p(length / width * (GROWTH - 1)) / np.log(GROWTH))))
    reach = np.expm1(np.arange(count + 1) * np.log(GROWTH))
    return length * reach / reach[-1]


def _place(rows: np.ndarray, at: int, factor: np.ndarray, constant: np.ndarray) -> None:
    """Rows at, at+1: real and imaginary part of factor·W + constant."""
    rows[:, at, 0], rows[:, at, 1], rows[:, at, 7] = factor.real, -factor.imag, constant.real
    rows[:, at + 1, 0], rows[:, at + 1, 1] = factor.imag, factor.real
    rows[:, at + 1, 7] = constant.imag


def _ends(driven: complex | None) -> tuple[np.ndarray, np.ndarray]:
    """Conditions on (W, W′, excess, ∫φ, 1), complex ones as two: W′ = 0, or W given, at y = 0."""
    left, right = np.zeros((5, 8)), np.zeros((3, 8))
    if driven is None:
        left[0, 2] = left[1, 3] = 1.0
    else:
        left[0, 0] = left[1, 1] = 1.0
        left[0, 7], left[1, 7] = -driven.real, -driven.imag
    left[2, 4] = left[3, 5] = left[4, 6] = 1.0
    right[0, 0] = right[1, 1] = right[2, 7] = 1.0
    return left, right

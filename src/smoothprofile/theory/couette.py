"""Planar Couette flow whose upper wall is painted: steady state, and two other smoothed walls.

Fluid on 0 ≤ y ≤ h above a plate at rest, a wall of speed V on h ≤ y ≤ 2h. The wall is known by
its indicator φ(z), z = (y_w − y)/ξ, painted at y_w: one in the wall, zero in the fluid.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import polygamma, zeta

from smoothprofile.theory.collocation import ORDER, gauss_stages, solve_linear
from smoothprofile.theory.planar import tanh_shift

Function = Callable[[np.ndarray], np.ndarray]

# Each panel is this much wider than its neighbour nearer to the wall. Its width is then some
# quarter of its distance, which eight Gauss points follow to 1e-12 where all decays exponentially.
GROWTH = 1.3


@dataclass(frozen=True)
class Channel:
    """u = Vy/h on 0 ≤ y ≤ h and V above; stress τ₀ = νV/h.

    height: h; speed: V; viscosity: ν, kinematic; density one.
    """

    height: float = 3.0
    speed: float = 1.0
    viscosity: float = 1.0

    def velocity(self, y: np.ndarray) -> np.ndarray:
        """u(y) of the sharp wall."""
        return self.speed * np.minimum(y / self.height, 1.0)

    @property
    def stress(self) -> float:
        """τ₀ = νV/h, the sharp wall's."""
        return self.retreated_stress(0.0)

    def retreated_stress(self, distance: float) -> float:
        """Vν/(h + ξs₀) of a wall that acts at h + ξs₀. distance: ξs₀."""
        return self.speed * self.viscosity / (self.height + distance)


@dataclass(frozen=True)
class Wall:
    """φ(z), z = (y_w − y)/ξ.

    indicator: z -> φ; thickness: ξ; position: y_w; core, edge: the z between which φ varies,
    infinite for a profile with no end.
    """

    indicator: Function
    thickness: float
    position: float = 3.0
    core: float = -math.inf
    edge: float = math.inf

    def value(self, y: np.ndarray) -> np.ndarray:
        """φ at y."""
        return self.indicator((self.position - y) / self.thickness)


@dataclass(frozen=True)
class Mesh:
    """Points y rising from 0 to 2h, and weights w with ∫g dy = Σ w g(y) (zero between panels)."""

    y: np.ndarray
    weights: np.ndarray

    def integral(self, values: np.ndarray) -> float:
        """∫₀²ʰ of a function known at y."""
        return float(self.weights @ values)


@dataclass(frozen=True)
class Moments:
    """Of f as a density of probability: ⟨y⟩, σ, m₃ = ⟨(y−⟨y⟩)³⟩, and ⟨y³⟩ − ⟨y⟩³.

    The last is no skewness: it is 3⟨y⟩σ² + m₃, positive for any f ≥ 0 on positive y.
    """

    mean: float
    deviation: float
    third: float
    cubes: float

    @property
    def skewness(self) -> float:
        """m₃/σ³."""
        return self.third / self.deviation**3


@dataclass(frozen=True, eq=False)
class Flow:
    """A flow on a mesh.

    velocity: uⁿ; predicted: u*, before the impulse (uⁿ where there is none); force: density f of
    the force on the fluid; stress: τ on the plate, from which f takes the fluid up to the wall.
    """

    channel: Channel
    mesh: Mesh
    velocity: np.ndarray
    predicted: np.ndarray
    force: np.ndarray
    stress: float

    @property
    def error(self) -> float:
        """√∫₀²ʰ (uⁿ − u)² dy, u the sharp wall's."""
        difference = self.velocity - self.channel.velocity(self.mesh.y)
        return math.sqrt(self.mesh.integral(difference**2))

    @property
    def stress_error(self) -> float:
        """(τ − τ₀)/τ₀."""
        return self.stress / self.channel.stress - 1.0

    @property
    def moments(self) -> Moments:
        """Of f, normalised."""
        y, density = self.mesh.y, self.force / self.mesh.integral(self.force)
        mean = self.mesh.integral(y * density)
        second, third = (self.mesh.integral((y - mean) ** n * density) for n in (2, 3))
        cubes = self.mesh.integral(y**3 * density) - mean**3
        return Moments(mean, math.sqrt(second), third, cubes)


def penalised(
    channel: Channel, wall: Wall, time_step: float, gamma: float = 1.0, implicit: float = 1.0
) -> Flow:
    """u* and uⁿ of the smoothed profile method at steady state.

        ν [θu* + (1−θ)uⁿ]'' = −f,    f = γφ(V − u*)/Δt,    uⁿ = u* + φ(V − u*)

    u*(0) = 0, u*(2h) = V, τ = ∫f dy. Solved for W = θu* + (1−θ)uⁿ − V:

        W'' = χW,    χ = γφ/((1 − (1−θ)φ)νΔt),    u* − V = W/(1 − (1−θ)φ)

    time_step: Δt; gamma, implicit: the scheme's γ (backward Euler and Crank–Nicolson 1) and θ
    (1; Crank–Nicolson ½). Source: the thesis' (3.2), which is γ = θ = 1.
    """
    explicit, speed, viscosity = 1.0 - implicit, channel.speed, channel.viscosity
    length = math.sqrt(viscosity * time_step / gamma)
    mesh = mesh_for(channel, wall, min(wall.thickness, length))
    top = 2.0 * channel.height

    # The distance from the far side of the wall, where W = 0, rises towards the plate.
    def matrix(depth: np.ndarray) -> np.ndarray:
        phi = wall.value(top - depth)
        rows = np.zeros((depth.size, 2, 2))
        rows[:, 0, 1] = 1.0
        rows[:, 1, 0] = phi / (1.0 - explicit * phi) / length**2
        return rows

    phi = wall.value(mesh.y)
    kept = 1.0 - explicit * phi
    plate = np.array([-speed * kept[0]])
    one = np.array([[1.0, 0.0]])
    found = solve_linear(matrix, top - mesh.y[::-1], one, one, plate)[::-1]
    lag = -found[:, 0] / kept
    return Flow(
        channel=channel,
        mesh=mesh,
        velocity=speed - (1.0 - phi) * lag,
        predicted=speed - lag,
        force=gamma * phi * lag / time_step,
        stress=float(viscosity * (found[-1, 1] - found[0, 1])),
    )


def tanh_moments(
    channel: Channel, thickness: float, ratio: float, implicit: float = 1.0
) -> Moments:
    """Of the force of `penalised` on a tanh wall painted at h, in closed form:

        ⟨y⟩ = h + ξs₀,    σ² = ξ²(π²/12 + κ²),    m₃ = −ξ³[ζ(3)/2 + ψ₂(1/(2κ))/4 + 2κ³]

    with κ = k√θ, and s₀ of `planar.tanh_shift`. thickness: ξ; ratio: k = √(νΔt/γ)/ξ;
    implicit: θ. The wall's far side at 2h counts as infinitely far.

    Derivation. f = −νW'', with W of the flat wall; θ < 1 moves it and takes κ for k. With
    z = (h−y)/ξ and a = 1/(2κ), W ∝ e^{z/κ}₂F₁(a, a; 1+2a; −e^{2z}), whose Mellin transform gives

        ⟨e^{tz}⟩ ∝ Γ(1−t/2)² Γ(a+t/2)/Γ(1+a−t/2).

    The cumulants of z are the derivatives of its logarithm at t = 0. The first one is −s₀: for
    any profile ∫yf dy = νV, so that the force is centred where the wall acts.
    """
    k = ratio * math.sqrt(implicit)
    mean = channel.height + thickness * tanh_shift(ratio, implicit)
    variance = thickness**2 * (math.pi**2 / 12.0 + k**2)
    bend = 0.5 * zeta(3.0) + 0.25 * polygamma(2, 0.5 / k) + 2.0 * k**3
    third = float(-(thickness**3) * bend)
    return Moments(mean, math.sqrt(variance), third, 3.0 * mean * variance + third)


def smoothed_force(channel: Channel, thickness: float) -> Flow:
    """u = V[y − ξ ln cosh((y−h)/ξ) + ξ ln cosh(h/ξ)]/(2h), of f = τ₀ dφ/dy and a tanh wall.

    νu'' = −f. The stress is τ₀ by construction (within e^{−2h/ξ}), and so the error is local:
    `smoothed_force_error`. thickness: ξ. Source: the thesis' (3.3–3.5), option 1.
    """
    height = channel.height
    wall = Wall(lambda z: 0.5 * (1.0 - np.tanh(z)), thickness, height)
    mesh = mesh_for(channel, wall, thickness)
    z = (mesh.y - height) / thickness
    # ln cosh z = ln(e^z + e^{−z}) − ln 2.
    rise = np.logaddexp(z, -z) - np.logaddexp(z[0], -z[0])
    velocity = channel.speed * (mesh.y - thickness * rise) / (2.0 * height)
    # dφ/dy = 2φ(1−φ)/ξ, each factor without cancellation in its own tail.
    force = channel.stress * 0.5 * (1 - np.tanh(z)) * (1 + np.tanh(z)) / thickness
    stress = channel.stress * 0.5 * (1.0 + math.tanh(height / thickness))
    return Flow(channel, mesh, velocity, velocity, force, stress)


def smoothed_force_error(channel: Channel, thickness: float) -> float:
    """√∫(u − u₀)²dy = √ζ(3) V ξ^{3/2}/(4h) of `smoothed_force`.

    u₀ − u = Vξ ln(1 + e^{−2|y−h|/ξ})/(2h), and ∫₀^∞ ln²(1 + e^{−t})dt = ζ(3)/4.
    """
    return math.sqrt(zeta(3.0)) * channel.speed * thickness**1.5 / (4.0 * channel.height)


def smoothed_viscosity(
    channel: Channel, wall: Wall, slope: Function, viscosity_ratio: float
) -> Flow:
    """(μu')' = 0, μ = ν(1−φ) + ν₁φ, u(0) = 0, u(2h) = V; τ = μu'.

    f = −νu'' = ντμ'/μ² is the force that a fluid of viscosity ν alone would need for this u.
    slope: z -> dφ/dz; viscosity_ratio: R = ν₁/ν. Source: the thesis' (3.6–3.7), option 2.
    """
    ratio, viscosity = viscosity_ratio, channel.viscosity
    # μ leaves ν where Rφ ~ 1: for tanh, ½ξ ln R out in the fluid.
    edge = 0.5 * math.log(ratio) if math.isinf(wall.edge) else wall.edge
    mesh = mesh_for(channel, replace(wall, edge=edge), wall.thickness)

    def fluidity(y: np.ndarray) -> np.ndarray:
        return 1.0 / (viscosity * (1.0 + (ratio - 1.0) * wall.value(y)))

    def matrix(y: np.ndarray) -> np.ndarray:
        rows = np.zeros((y.size, 2, 2))
        rows[:, 0, 1] = fluidity(y)
        return rows

    one = np.array([[1.0, 0.0]])
    velocity, stress = solve_linear(matrix, mesh.y, one, one, np.array([channel.speed])).T
    z = (wall.position - mesh.y) / wall.thickness
    growth = -(ratio - 1.0) * viscosity * slope(z) / wall.thickness
    force = viscosity * stress * growth * fluidity(mesh.y) ** 2
    return Flow(channel, mesh, velocity, velocity, force, float(stress[0]))


def smoothed_viscosity_stress(channel: Channel, thickness: float, viscosity_ratio: float) -> float:
    """τ = Vν/[2h/R + (1 − 1/R)(h − ½ξ ln R)] of a tanh wall, within e^{−2h/ξ}.

    ν/μ = 1/R + (1 − 1/R)/(1 + Re^{2(y−h)/ξ}): a step that stands ½ξ ln R in front of the wall,
    and a wall that still shears. thickness: ξ; viscosity_ratio: R = ν₁/ν.
    """
    ratio = viscosity_ratio
    film = channel.height - 0.5 * thickness * math.log(ratio)
    depth = 2.0 * channel.height / ratio + (1.0 - 1.0 / ratio) * film
    return channel.speed * channel.viscosity / depth


def mesh_for(channel: Channel, wall: Wall, width: float) -> Mesh:
    """Panels from 0 to 2h: even where φ varies, of growing width away from there.

    Gauss' points and the panels' ends are the mesh, so that whatever is known there can be
    integrated. The ends of the profile and h, where the sharp velocity has its kink, are ends
    of panels. width: of the first ones, the shortest length of the problem. ValueError if the
    profile leaves the channel.
    """
    top = 2.0 * channel.height
    low = wall.position - wall.thickness * (wall.edge if math.isfinite(wall.edge) else 0.0)
    high = wall.position - wall.thickness * (wall.core if math.isfinite(wall.core) else 0.0)
    if not 0.0 < low <= high < top:
        raise ValueError(f"The painted wall varies from y = {low:g} to {high:g}, not in 0…{top:g}.")
    across = np.linspace(low, high, math.ceil((high - low) / width) + 1)
    outer = (_away(low, 0.0, width), _away(high, top, width))
    ends = np.unique(np.concatenate((*outer, across)))
    if np.abs(ends - channel.height).min() > 1e-9 * width:
        ends = np.union1d(ends, [channel.height])
    nodes, _, shares = gauss_stages(ORDER)
    widths = np.diff(ends)[:, None]
    y = np.hstack((ends[:-1, None], ends[:-1, None] + widths * nodes))
    weights = np.hstack((np.zeros_like(widths), widths * shares))
    return Mesh(np.append(y, top), np.append(weights, 0.0))


def _away(start: float, stop: float, width: float) -> np.ndarray:
    """Ends of panels from start to stop, each wider by GROWTH; the first at most `width`."""
    count = math.ceil(math.log1p(abs(stop - start) / width * (GROWTH - 1)) / math.log(GROWTH))
    reach = GROWTH ** np.arange(count + 1) - 1.0
    return start + (stop - start) * reach / reach[-1]

"""The curves behind the figures of the dipole study, and the thesis' own numerical problem."""

from collections.abc import Sequence

import numpy as np

from smoothprofile.calibration import dielectric_slope, effective_radius
from smoothprofile.profiles import PROFILES
from smoothprofile.theory import dielectric

FIRST, LAST = 0.5, 2.0
SHOWN = {"ratio": 10.0, "thickness": 0.1}
RATIOS = (0.1, 2.0, 10.0, 100.0)
THICKNESSES = (0.05, 0.1, 0.2)
RETRACTED = (2.0, 20.0, 40.0)
MULTIPOLES = {1: "dipole", 2: "quadrupole", 3: "octupole"}


def thesis_field(
    degree: int,
    ratio: float,
    thickness: float,
    profile: str,
    smoothing: str = "arithmetic",
    painted: float = 1.0,
    points: Sequence[float] = (),
    inner_permittivity: float | None = None,
) -> dielectric.RadialField:
    """One multipole on ½ ≤ r ≤ 2, from the sharp sphere's field at r = ½ for a unit field.

    painted: the radius at which the surface is painted; the exact sphere's is 1. points: radii
    at which the solution is wanted. inner_permittivity: ε in D = lεF/r at r = ½; ε₁ if left out.
    Source: thesis (4.8–4.10), (4.24).
    """
    known = PROFILES[profile]
    edges = dielectric.interface_edges(
        painted, thickness, known.core, known.edge, ratio, FIRST, LAST
    )
    return dielectric.solve_multipole(
        *(degree, ratio, painted_indicator(profile, thickness, painted), smoothing),
        edges=np.union1d(edges, points),
        inner_amplitude=1.0 - dielectric.sharp_factor(degree, ratio),
        inner_permittivity=inner_permittivity or ratio,
    )


def painted_indicator(profile: str, thickness: float, painted: float = 1.0) -> dielectric.Function:
    """φ(r) of a sphere painted with radius `painted`."""
    value = PROFILES[profile].value
    return lambda r: value((r - painted) / thickness)


def moment_error(
    degree: int,
    ratio: float,
    thickness: float,
    profile: str,
    smoothing: str = "arithmetic",
    painted: float = 1.0,
) -> float:
    """(B − B₀)/B₀ = a_eff^{2l+1} − 1 for a sphere that should have radius 1."""
    found = effective_radius(painted, thickness, ratio, profile, smoothing, degree)
    return found ** (2 * degree + 1) - 1.0


def retracted_error(degree: int, ratio: float, thickness: float, profile: str) -> float:
    """The same after the thesis' correction: the sphere painted with radius 1/a_eff."""
    painted = 1.0 / effective_radius(1.0, thickness, ratio, profile, "arithmetic", degree)
    return moment_error(degree, ratio, thickness, profile, painted=painted)


def all_curves() -> dict[str, dict[str, np.ndarray]]:
    """Name of the CSV file -> its columns."""
    curves = {"field": _field(), "indicators": _indicators(), "permittivity": _permittivity()}
    for profile in ("tanh", "quartic"):
        curves[f"{profile}_against_thickness"] = _against_thickness(profile)
        curves[f"{profile}_against_ratio"] = _against_ratio(profile)
    return curves | {
        "smoothings_against_ratio": _smoothings(),
        "retraction": _retraction(),
        "tensor_against_thickness": _tensor(),
    }


def _field() -> dict[str, np.ndarray]:
    radius = np.linspace(FIRST, LAST, 301)
    found = thesis_field(1, profile="tanh", points=radius, **SHOWN)
    keep = np.isin(found.radius, radius)
    exact = dielectric.sharp_field(1, SHOWN["ratio"], 1.0, radius)
    return {
        "r": radius,
        "potential": found.potential[keep],
        "exact_potential": exact[0],
        "displacement": found.displacement[keep],
        "exact_displacement": exact[1],
    }


def _indicators() -> dict[str, np.ndarray]:
    z = np.linspace(-1.5, 1.5, 301)
    return {"z": z} | {name: profile.value(z) for name, profile in PROFILES.items()}


def _permittivity() -> dict[str, np.ndarray]:
    radius = np.linspace(0.5, 1.5, 401)
    columns = {"r": radius}
    for smoothing in ("arithmetic", "harmonic"):
        indicator = painted_indicator("tanh", 0.1)
        columns[smoothing] = dielectric.permittivities(indicator, 100.0, smoothing)[0](radius)
    return columns


def _against_thickness(profile: str) -> dict[str, np.ndarray]:
    thickness = np.geomspace(0.01, 0.3, 21)
    columns = {"thickness": thickness}
    for ratio in RATIOS:
        found = _radii(thickness, [ratio], profile, "arithmetic")
        columns |= {f"error_R{ratio:g}": found**3 - 1, f"radius_R{ratio:g}": found}
    return columns


def _against_ratio(profile: str) -> dict[str, np.ndarray]:
    ratio = np.geomspace(0.01, 100.0, 41)
    columns = {"ratio": ratio}
    for thickness in THICKNESSES:
        found = _radii([thickness], ratio, profile, "arithmetic")
        columns |= {
            f"error_{thickness:g}": found**3 - 1,
            f"radius_{thickness:g}": found,
            f"scaled_{thickness:g}": (found - 1) / thickness,
        }
    slopes = [dielectric_slope(value, profile, "arithmetic") for value in ratio]
    return columns | {"scaled_limit": np.array(slopes)}


def _smoothings() -> dict[str, np.ndarray]:
    ratio = np.geomspace(0.01, 100.0, 41)
    columns = {"ratio": ratio}
    for thickness in (0.1, 0.2):
        for profile in ("tanh", "sine"):
            for smoothing in dielectric.SMOOTHINGS:
                found = _radii([thickness], ratio, profile, smoothing)
                columns[f"{profile}_{smoothing}_{thickness:g}"] = found**3 - 1
    return columns


def _retraction() -> dict[str, np.ndarray]:
    thickness = np.geomspace(0.01, 0.3, 13)
    columns: dict[str, np.ndarray] = {"thickness": thickness}
    for degree in (1, 2):
        for ratio in RETRACTED:
            name = f"{MULTIPOLES[degree]}_R{ratio:g}"
            arguments = (degree, ratio)
            columns[name] = np.array([moment_error(*arguments, x, "quartic") for x in thickness])
            columns[f"{name}_retracted"] = np.array(
                [retracted_error(*arguments, x, "quartic") for x in thickness]
            )
    return columns


def _tensor() -> dict[str, np.ndarray]:
    thickness = np.geomspace(0.01, 0.3, 13)
    columns = {"thickness": thickness}
    for degree, name in MULTIPOLES.items():
        for profile in PROFILES:
            columns[f"{name}_{profile}"] = np.array(
                [moment_error(degree, 10.0, x, profile, "tensor") for x in thickness]
            )
    return columns


def _radii(
    thicknesses: Sequence[float], ratios: Sequence[float], profile: str, smoothing: str
) -> np.ndarray:
    """a_eff of the dipole for every pair, one of the two sequences being of length one."""
    return np.array(
        [
            effective_radius(1.0, float(thickness), float(ratio), profile, smoothing)
            for thickness in thicknesses
            for ratio in ratios
        ]
    )

"""A dielectric sphere in a non-uniform field: the force on it, and the radius that decides it."""

import math
from dataclasses import dataclass

import numpy as np

from smoothprofile.calibration import dielectric_radius, effective_radius
from smoothprofile.studies.dipole_curves import painted_indicator, thesis_field
from smoothprofile.studies.sphere_force_figures import pictures
from smoothprofile.studies.study import Row, Study
from smoothprofile.theory import dielectric, maxwell

RATIO = 2.0
CORRECTIONS = ("uncorrected", "dipole", "quadrupole", "both")

# Columns of table 4.1: ξ, then exact force, force and error of the thesis, error confirmed.
TABLE_1 = (
    (0.05, 6.16075, 6.34617, -0.0301, -0.0313),
    (0.10, 6.06983, 6.52032, -0.0742, -0.0743),
    (0.15, 6.00330, 6.78126, -0.1296, -0.1297),
    (0.20, 5.95242, 7.13116, -0.1980, -0.1981),
)

# Table 4.2: ξ: exact force, then force and error of each correction, as the thesis prints them.
TABLE_2 = {
    0.05: (6.24759, 6.34598, -0.0157, 6.36382, -0.0428, 6.36394, -0.0428, 6.35423, -0.0412),
    0.08: (6.22039, 6.35012, -0.0209, 6.20182, -0.0162, 6.21201, -0.0179, 6.20259, -0.0164),
    0.11: (6.19451, 6.36401, -0.0274, 6.19622, -0.0153, 6.17095, -0.0112, 6.19668, -0.0154),
    0.14: (6.18848, 6.42707, -0.0386, 6.20130, -0.0162, 6.16945, -0.0109, 6.19651, -0.0154),
    0.17: (6.17990, 6.45138, -0.0439, 6.21291, -0.0181, 6.17625, -0.0121, 6.19964, -0.0159),
    0.20: (6.16371, 6.46873, -0.0495, 6.18587, -0.0136, 6.13947, -0.0060, 6.17183, -0.0113),
    0.23: (6.14404, 6.50918, -0.0594, 6.13758, -0.0057, 6.07430, 0.0046, 6.13288, -0.0050),
    0.26: (6.12672, 6.55890, -0.0705, 6.11985, -0.0028, 6.03738, 0.0107, 6.12177, -0.0031),
    0.29: (6.11356, 6.61014, -0.0812, 6.11419, -0.0019, 6.01716, 0.0140, 6.11602, -0.0022),
    0.32: (6.10265, 6.64650, -0.0891, 6.12197, -0.0032, 6.01469, 0.0144, 6.12109, -0.0030),
}

# The errors of table 4.2 as they were confirmed: uncorrected, by the dipole, by the quadrupole.
CONFIRMED = {
    0.05: (-0.01181, -0.00005, 0.00118),
    0.08: (-0.01924, -0.00013, 0.00213),
    0.11: (-0.02691, -0.00025, 0.00324),
    0.14: (-0.03485, -0.00042, 0.00450),
    0.17: (-0.04305, -0.00064, 0.00589),
    0.20: (-0.05151, -0.00092, 0.00741),
    0.23: (-0.06024, -0.00127, 0.00904),
    0.26: (-0.06924, -0.00168, 0.01076),
    0.29: (-0.07852, -0.00216, 0.01255),
    0.32: (-0.08806, -0.00272, 0.01440),
}

INTRODUCTION = (
    "A dielectric sphere, a = 1, ε₁/ε₂ = 2, ε₂ = 1, in a field that is uniform and changes "
    "linearly: ψ = F₁(r)cosθ + F₂(r)P₂(cosθ), (r²εF_l')' = l(l+1)εF_l, ε interpolated, on "
    "½ ≤ r ≤ 2 and started at r = ½ from the sharp sphere's field for E∞ = E_A2 = 1. The force is "
    "the Maxwell stress on a Gauss sphere (thesis 4.22–4.23), whose integral over angles is "
    "(8π/15)(rF₁' − F₁)(rF₂' + 3F₂). The exact force is 8πE∞E_A2K with the E∞ and E_A2 that the "
    "solution turns out to have, K = (R−1)/(R+2). Error: (exact − found)/exact."
)

FINDINGS = (
    "The force is 8πBE_A2 on any Gauss sphere in the fluid: B is the dipole's, and the "
    "quadrupole's own moment drops out. Its error is exactly 1 − a_eff³ of the dipole.",
    "So painting with radius 1/a_eff of the dipole is the right correction, that of the "
    "quadrupole the wrong one, and both together the same as the dipole alone.",
    "The corrected force is of second order in ξ. The thesis finds no order because its "
    "corrected columns divide by one exact force, 6.10265, which is that of ξ = 0.32; its other "
    "numbers carry the noise of its solver, up to 0.004.",
    "With the radius for which a_eff = a nothing is left of the error, at any ξ.",
    "A Gauss sphere at a + ξ/2 is outside the quartic's layer. tanh needs a + 5ξ: at a + 2.5ξ, "
    "which the thesis recommends, the stress shows an error of −1.0 % in place of −3.1 %.",
)


@dataclass(frozen=True)
class Force:
    """The force found, and the exact one in the field that the solution turned out to have."""

    found: float
    exact: float

    @property
    def error(self) -> float:
        return (self.exact - self.found) / self.exact


def force(
    thickness: float,
    profile: str,
    gauss: float,
    painted: tuple[float, float] = (1.0, 1.0),
    ratio: float = RATIO,
    smoothing: str = "arithmetic",
) -> Force:
    """The force by the stress at r = `gauss`; painted: radii for the dipole and the quadrupole."""
    fields = [
        thesis_field(degree, ratio, thickness, profile, smoothing, radius, [gauss])
        for degree, radius in zip((1, 2), painted, strict=True)
    ]
    factor = dielectric.sharp_factor(1, ratio)
    return Force(
        maxwell.gauss_force(gauss, fields[0].at(gauss), fields[1].at(gauss)),
        maxwell.exact_force(fields[0].external, fields[1].external, factor),
    )


def corrected(thickness: float, correction: str, ratio: float = RATIO) -> Force:
    """A line of table 4.2: the quartic, its surface retracted to 1/a_eff."""
    dipole, quadrupole = (
        1.0 / effective_radius(1.0, thickness, ratio, "quartic", "arithmetic", degree)
        for degree in (1, 2)
    )
    painted = {
        "uncorrected": (1.0, 1.0),
        "dipole": (dipole, dipole),
        "quadrupole": (quadrupole, quadrupole),
        "both": (dipole, quadrupole),
    }
    return force(thickness, "quartic", 1.0 + 0.5 * thickness, painted[correction], ratio)


def run() -> Study:
    """The thesis' section 4.2, solved to round-off."""
    curves = {
        "gauss_quartic": _against_gauss("quartic", 0.2),
        "gauss_tanh": _against_gauss("tanh", 0.05),
        "error_against_thickness": _against_thickness(),
        "error_against_ratio": _against_ratio(),
    }
    rows = [*_sharp(), *_table_1(), *_gauss(), *_table_2_errors(), *_orders(), *_cured()]
    return Study(
        title="Force on a dielectric sphere in a non-uniform field",
        source="Thesis, section 4.2",
        introduction=INTRODUCTION,
        findings=FINDINGS,
        rows=[*rows, *_table_2_forces()],
        curves=curves,
        pictures=pictures(curves),
    )


def _sharp() -> list[Row]:
    """The sharp sphere with E∞ = E_A2 = 1 on a Gauss sphere of 1.1 a."""
    r, k1, k2 = 1.1, dielectric.sharp_factor(1, RATIO), dielectric.sharp_factor(2, RATIO)
    dipole = r - k1 / r**2, 1 + 2 * k1 / r**3
    quadrupole = r**2 - k2 / r**3, 2 * r + 3 * k2 / r**4
    closed = maxwell.gauss_force(r, dipole, quadrupole)
    summed = maxwell.stress_integral(r, dipole, quadrupole, 500)
    remark = "the rule's error, of order intervals⁻²"
    return [
        Row("force on the sharp sphere", 6.28319, 2 * math.pi, closed, 1e-12),
        Row("same, by the trapezoidal rule of 500", 6.28299, None, summed, 0.0, remark),
    ]


def _table_1() -> list[Row]:
    rows = []
    for thickness, exact, found, error, confirmed in TABLE_1:
        ours = force(thickness, "tanh", 1.0 + 5 * thickness)
        name = f"table 4.1, ξ = {thickness:.2f}"
        noise = "noise of the thesis' solver" if abs(error - confirmed) > 5e-4 else ""
        rows += [
            Row(f"{name}: exact force", exact, None, ours.exact, 0.0),
            Row(f"{name}: force", found, None, ours.found, 0.0),
            Row(f"{name}: error", error, confirmed, ours.error, 5e-5, noise),
        ]
    return rows


def _gauss() -> list[Row]:
    near = 100 * force(0.05, "tanh", 1.0 + 2.5 * 0.05).error
    far = 100 * force(0.05, "tanh", 1.0 + 5 * 0.05).error
    remark = "the thesis takes r ≥ a + 2.5ξ for large enough; ε is 1.0067 there"
    return [
        Row("error at r = a + 2.5ξ, %: tanh, ξ = 0.05", "figure", -1.0, near, 0.05, remark),
        Row("error at r = a + 5ξ, %: tanh, ξ = 0.05", -3.01, -3.13, far, 0.005),
    ]


def _table_2_errors() -> list[Row]:
    rows = []
    for number, correction in enumerate(CORRECTIONS):
        for thickness, printed in TABLE_2.items():
            # The quadrupole's radius plays no part: both is as the dipole.
            confirmed = CONFIRMED[thickness][(0, 1, 2, 1)[number]]
            # 6.10265 is the exact force of the last line, which is right to divide by there.
            stale = number and thickness != 0.32
            remark = "the thesis divides by 6.10265, the exact force of ξ = 0.32"
            if not stale:
                far = abs(printed[2 + 2 * number] - confirmed) > 5e-5
                remark = "noise of the thesis' solver" if far else ""
            rows.append(
                Row(
                    f"table 4.2, ξ = {thickness:.2f}, {correction}: error",
                    *(printed[2 + 2 * number], confirmed, corrected(thickness, correction).error),
                    tolerance=5e-6,
                    remark=remark,
                )
            )
    return rows


def _table_2_forces() -> list[Row]:
    """The forces of table 4.2, beside a_eff³ times the exact force in the same field."""
    rows = []
    for thickness, printed in TABLE_2.items():
        name = f"table 4.2, ξ = {thickness:.2f}"
        plain = corrected(thickness, "uncorrected")
        rows.append(Row(f"{name}: exact force", printed[0], None, plain.exact, 0.0))
        for number, correction in enumerate(CORRECTIONS):
            ours = corrected(thickness, correction)
            degree = 2 if correction == "quadrupole" else 1
            size = effective_radius(1.0, thickness, RATIO, "quartic", "arithmetic", degree)
            painted = 1.0 if correction == "uncorrected" else 1.0 / size
            moment = effective_radius(painted, thickness, RATIO, "quartic", "arithmetic") ** 3
            rows.append(
                Row(
                    f"{name}, {correction}: force",
                    *(printed[1 + 2 * number], moment * ours.exact, ours.found, 1e-8),
                    "exact: 8πE∞E_A2K a_eff³",
                )
            )
    return rows


def _orders() -> list[Row]:
    rows = []
    for correction, thesis, order in (
        ("uncorrected", "about 1", 1),
        ("dipole", "not clear", 2),
        ("quadrupole", "not clear", 1),
        ("both", "not clear", 2),
    ):
        errors = [corrected(thickness, correction).error for thickness in (2e-3, 1e-3)]
        found = math.log2(errors[0] / errors[1])
        # Between 2e-3 and 1e-3 the next power of ξ is below 0.03 of the leading one.
        rows.append(Row(f"order in ξ: {correction}", thesis, order, found, 0.03))
    return rows


def _cured() -> list[Row]:
    rows = []
    for profile, smoothing in (("tanh", "tensor"), ("sine", "tensor"), ("sine", "arithmetic")):
        plain = force(0.1, profile, 1.8, smoothing=smoothing)
        painted = dielectric_radius(1.0, 0.1, RATIO, profile, smoothing)
        cured = force(0.1, profile, 1.8, (painted, painted), smoothing=smoothing)
        name = f"error, {profile}, {smoothing}, ξ = 0.1"
        # tanh: φ = 1 − 5e-5 at the thesis' r = ½, where the field is started.
        tolerance = 1e-5 if profile == "tanh" else 1e-10
        rows += [
            Row(name, None, None, plain.error, 0.0),
            Row(f"{name}, painted with {painted:.6f}", None, 0.0, cured.error, tolerance),
        ]
    return rows


def _against_gauss(profile: str, thickness: float) -> dict[str, np.ndarray]:
    radius = np.linspace(0.75, 1.4, 66)
    errors = [force(thickness, profile, float(r)).error for r in radius]
    indicator = painted_indicator(profile, thickness)
    permittivity = dielectric.permittivities(indicator, RATIO, "arithmetic")[0](radius)
    return {"r": radius, "error": np.array(errors), "permittivity": permittivity}


def _against_thickness() -> dict[str, np.ndarray]:
    thickness = np.array(list(TABLE_2))
    columns = {"thickness": thickness}
    for number, correction in enumerate(CORRECTIONS):
        columns[correction] = np.array([corrected(xi, correction).error for xi in thickness])
        columns[f"thesis_{correction}"] = np.array(
            [printed[2 + 2 * number] for printed in TABLE_2.values()]
        )
    return columns


def _against_ratio() -> dict[str, np.ndarray]:
    """1 − a_eff³ of the dipole: the force's error, for any R."""
    ratio = np.geomspace(0.01, 100.0, 41)
    columns = {"ratio": ratio}
    for thickness in (0.05, 0.1, 0.2):
        for profile in ("quartic", "sine"):
            smoothing = "arithmetic" if profile == "quartic" else "tensor"
            radii = [effective_radius(1.0, thickness, r, profile, smoothing) for r in ratio]
            columns[f"{profile}_{smoothing}_{thickness:g}"] = 1 - np.array(radii) ** 3
    return columns

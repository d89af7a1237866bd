"""What smoothing does to a surface, from theory, and how to undo it: flow and electric field."""

from smoothprofile.calibration.dielectric import (
    dielectric_offset,
    dielectric_radius,
    dielectric_slope,
    effective_radius,
)
from smoothprofile.calibration.flow import (
    best_ratio,
    best_time_step,
    interface_shift,
    painted_radius,
    resistance_ratio,
    surface_offset,
)
from smoothprofile.calibration.stokes import StokesSphere, stokes_shift, stokes_sphere

__all__ = [
    "StokesSphere",
    "best_ratio",
    "best_time_step",
    "dielectric_offset",
    "dielectric_radius",
    "dielectric_slope",
    "effective_radius",
    "interface_shift",
    "painted_radius",
    "resistance_ratio",
    "stokes_shift",
    "stokes_sphere",
    "surface_offset",
]

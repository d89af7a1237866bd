"""Particles in incompressible flow by the smoothed profile method."""

# First of all: it tells the thread pools how to wait, which they read once when they load.
from smoothprofile import threads  # isort: skip
from smoothprofile import calibration, shapes
from smoothprofile.config import Case, load_case
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.signals import Signal
from smoothprofile.simulation import Simulation

__version__ = "0.1.0"

__all__ = [
    "BlowUpError",
    "Case",
    "CaseError",
    "Signal",
    "Simulation",
    "__version__",
    "calibration",
    "load_case",
    "shapes",
    "threads",
]

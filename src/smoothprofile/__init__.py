"""Particles in incompressible flow by the smoothed profile method.

What the package offers is imported at first use, so that a part of it works without the others.
"""

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

# Thread pools read once, when they load, how to wait: see threads.py.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "0")

if TYPE_CHECKING:
    from smoothprofile import calibration, shapes, suspension, threads
    from smoothprofile.config import Case, load_case
    from smoothprofile.electrostatics import Electrostatics
    from smoothprofile.errors import BlowUpError, CaseError
    from smoothprofile.runs import from_file
    from smoothprofile.signals import Signal
    from smoothprofile.simulation import Simulation
    from smoothprofile.stokes_simulation import StokesSimulation

__version__ = "0.1.0"

_HOMES = {
    "BlowUpError": "errors",
    "Case": "config",
    "CaseError": "errors",
    "Electrostatics": "electrostatics",
    "Signal": "signals",
    "Simulation": "simulation",
    "StokesSimulation": "stokes_simulation",
    "from_file": "runs",
    "load_case": "config",
}
_MODULES = ("calibration", "shapes", "suspension", "threads")

__all__ = [
    "BlowUpError",
    "Case",
    "CaseError",
    "Electrostatics",
    "Signal",
    "Simulation",
    "StokesSimulation",
    "__version__",
    "calibration",
    "from_file",
    "load_case",
    "shapes",
    "suspension",
    "threads",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"smoothprofile.{name}")
    if name in _HOMES:
        return getattr(import_module(f"smoothprofile.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'smoothprofile' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

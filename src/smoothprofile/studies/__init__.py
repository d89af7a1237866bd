"""Studies, one file each: the thesis' experiments, its numbers beside exact ones, and more."""

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

from smoothprofile.config.refusals import nearest, shown
from smoothprofile.errors import CaseError
from smoothprofile.studies.study import Study

STUDIES: dict[str, str] = {
    "couette": "A flat wall at rest in shear: best Δt, shift of the wall (thesis 3.1)",
    "stokes-layer": "An oscillating flat wall: amplitude and phase (thesis 3.2)",
    "dipole": "A dielectric sphere in a uniform field (thesis 4.1)",
    "sphere-force": "A dielectric sphere in a non-uniform field (thesis 4.2)",
    "lattice": "A periodic lattice of dielectric spheres (thesis 4.3)",
    "profiles": "Which profile and smoothing of permittivity is most accurate",
    "viscosity": "Effective viscosity of a dilute suspension, and the stresslet of a sphere",
    "dns": "Spheres in a duct and in arrays by body-fitted finite elements (needs ngsolve)",
    "smoothed-viscosity": "Spheres made stiff by a smoothed viscosity (thesis 3.1, option 2)",
    "refinement": "Cells that cluster around a sphere in a duct, beside equal ones",
    "methods": "Every method on the same problems: force, error, seconds",
    "mason": "Beads between sliding electrodes: apparent viscosity against the Mason number",
}
"""Name -> what it is about. The function `run` of the file of that name does it."""

TAKES: dict[str, str] = {
    "couette": "about 20 s",
    "stokes-layer": "about 20 s",
    "dipole": "about 10 s",
    "sphere-force": "about 10 s",
    "lattice": "about 1 min",
    "profiles": "about 3 min",
    "viscosity": "about 30 s",
    "dns": "about 2 min",
    "smoothed-viscosity": "about 20 s",
    "refinement": "about 2 min",
    "methods": "about 1 min",
    "mason": "some minutes",
}
"""Name -> how long it took: what is solved in one dimension and `profiles` on one core, the rest
on two to four."""

NEEDS: dict[str, str] = {"dns": "ngsolve"}
"""Name -> the package that it needs beside those of the program."""


def can_run(name: str) -> bool:
    """Whether what the study needs is installed."""
    return name not in NEEDS or find_spec(NEEDS[name]) is not None


def study_named(name: str) -> Callable[[], Study]:
    """The function that runs a study; CaseError with the nearest name if there is none."""
    if name not in STUDIES:
        like = nearest(name, list(STUDIES))
        offer = f"the nearest is {like}" if like else f"there are {', '.join(STUDIES)}"
        raise CaseError(f"no study is called {shown(name)}; {offer}.")
    return import_module(f"smoothprofile.studies.{name.replace('-', '_')}").run

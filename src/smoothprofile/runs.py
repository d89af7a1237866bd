"""Which kind of run a case is."""

from collections.abc import Mapping
from os import PathLike

from smoothprofile.config import Case, is_stokes, load_case
from smoothprofile.electrostatics import Electrostatics
from smoothprofile.simulation import Simulation
from smoothprofile.stokes_simulation import StokesSimulation

Run = Simulation | StokesSimulation | Electrostatics


def run_of(case: Case) -> Run:
    """A Simulation for a case with [fluid], or one without inertia; Electrostatics without."""
    if case.fluid is None:
        return Electrostatics(case)
    return StokesSimulation(case) if is_stokes(case) else Simulation(case)


def from_file(
    case: str | PathLike | Mapping | Case, overrides: Mapping | list | None = None
) -> Run:
    """The run of a TOML file, a built-in case's name or a dict; {"time.end": 2} changes it."""
    return run_of(load_case(case, overrides or {}))

"""Which kind of run a case is."""

from collections.abc import Mapping
from os import PathLike

from smoothprofile.config import Case, load_case
from smoothprofile.electrostatics import Electrostatics
from smoothprofile.simulation import Simulation

Run = Simulation | Electrostatics


def run_of(case: Case) -> Run:
    """A Simulation for a case with [fluid], Electrostatics for one of a field alone."""
    return Electrostatics(case) if case.fluid is None else Simulation(case)


def from_file(
    case: str | PathLike | Mapping | Case, overrides: Mapping | list | None = None
) -> Run:
    """The run of a TOML file, a built-in case's name or a dict; {"time.end": 2} changes it."""
    return run_of(load_case(case, overrides or {}))

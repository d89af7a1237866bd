"""Cases: what a TOML file may say, checked before anything runs."""

from smoothprofile.config.case import Case, Profile, Start, Time
from smoothprofile.config.domain import Domain, Faces, Focus
from smoothprofile.config.electric import SPECTRAL, Electric, has_edges
from smoothprofile.config.fluid import Fluid, MeanVelocity, WallVelocity
from smoothprofile.config.gaps import smallest_gap
from smoothprofile.config.output import Line, Output, PlaneCut, WallLine
from smoothprofile.config.particle import Particle, Solid, body_shape, build_shape, start_position
from smoothprofile.config.reading import load_case, seeds_of, unfilled_lattices
from smoothprofile.config.stokes import is_stokes, nothing_moves
from smoothprofile.config.values import AXES, SIDES

__all__ = [
    "AXES",
    "SIDES",
    "SPECTRAL",
    "Case",
    "Domain",
    "Electric",
    "Faces",
    "Fluid",
    "Focus",
    "Line",
    "MeanVelocity",
    "Output",
    "Particle",
    "PlaneCut",
    "Profile",
    "Solid",
    "Start",
    "Time",
    "WallLine",
    "WallVelocity",
    "body_shape",
    "build_shape",
    "has_edges",
    "is_stokes",
    "load_case",
    "nothing_moves",
    "seeds_of",
    "smallest_gap",
    "start_position",
    "unfilled_lattices",
]

"""Steady flow past a sharp sphere by finite elements, on a mesh that fits it.

Nothing of the smoothed profile method is used: no indicator, no grid, no step in time. So these
forces are a reference for it. Only here is ngsolve called, which the extra `dns` installs.
"""

from importlib.util import find_spec

from smoothprofile.errors import CaseError

NEEDED = "ngsolve"


def is_available() -> bool:
    """Whether ngsolve is installed."""
    return find_spec(NEEDED) is not None


def require() -> None:
    """CaseError, one sentence that says how to install it, if ngsolve is missing."""
    if not is_available():
        raise CaseError(f"finite elements need {NEEDED}: pip install 'smoothprofile[dns]'.")

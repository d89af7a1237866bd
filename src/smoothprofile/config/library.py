"""Where the built-in cases and their references lie, and which there are."""

from importlib.resources import files
from pathlib import Path

from smoothprofile.config.refusals import nearest, shown
from smoothprofile.errors import CaseError

FOLDER = Path(str(files("smoothprofile"))) / "cases"


def case_names() -> list[str]:
    """Names of the built-in cases, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def reference_names() -> list[str]:
    """Names of the built-in references, sorted."""
    return sorted(path.stem for path in (FOLDER / "references").glob("*.json"))


def case_path(name: str) -> Path:
    """File of a built-in case; CaseError with the nearest name if there is none."""
    if name not in case_names():
        raise CaseError(f"no built-in case is called {shown(name)}; {_offer(name, case_names())}.")
    return FOLDER / f"{name}.toml"


def reference_path(name: str) -> Path:
    """File of a built-in reference; CaseError with the nearest name if there is none."""
    if name not in reference_names():
        raise CaseError(f"no reference is called {shown(name)}; {_offer(name, reference_names())}.")
    return FOLDER / "references" / f"{name}.json"


def _offer(name: str, names: list[str]) -> str:
    match = nearest(name, names, 0.4)
    return f"the nearest is {match}" if match else f"there are {', '.join(names)}"

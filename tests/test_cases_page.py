"""docs/cases.md: every key that a case may have stands there, with what is allowed."""

import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from smoothprofile.config.case import Case
from smoothprofile.config.dimensionless import Numbers
from smoothprofile.config.domain import Faces, Focus
from smoothprofile.config.files import COLUMNS
from smoothprofile.config.particle import SIZES, Particle, Solid
from smoothprofile.config.refusals import _table_in
from smoothprofile.config.tables import Lattice, RandomPacking, Sizes, Spread
from smoothprofile.config.tomltext import inline
from smoothprofile.config.values import SignalTable

PAGE = (Path(__file__).parent.parent / "docs" / "cases.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| `([a-zA-Z_.]+)` \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)
# Tables that many keys share, or that a key may hold beside a plain value, stand by themselves.
OWN_TABLES = {
    "numbers": (Numbers,),
    "stretching": (Focus, Faces),
    "signal": (SignalTable,),
    "parts": (Solid,),
    "lattice": (Lattice,),
    "random": (RandomPacking,),
    "radius": (Spread, Sizes),
}


def fields(model, prefix):
    """(key, field) of a model and of the tables in it."""
    for name, field in model.model_fields.items():
        yield f"{prefix}{name}", field
        inner = _table_in(field.annotation)
        if inner is not None and not (model is Particle and name in OWN_TABLES):
            yield from fields(inner, f"{prefix}{name}.")


def every_field():
    found = dict(fields(Case, ""))
    for name, models in OWN_TABLES.items():
        for model in models:
            found |= dict(fields(model, f"{name}."))
    return found


def test_every_key_stands_on_the_page():
    rows = {key: (default, allowed) for key, default, allowed, _ in ROW.findall(PAGE)}
    wanted = every_field()
    assert len(wanted) > 120
    assert set(rows) == set(wanted)
    for key, field in wanted.items():
        default, allowed = rows[key]
        assert allowed == field.description, key
        # A plain default stands there as TOML; what depends on the case is said in words.
        plain = not isinstance(field.default, BaseModel) and default.startswith("`")
        assert not plain or default == f"`{inline(field.default)}`", key
        assert default != "none" or not field.is_required(), key


@pytest.mark.parametrize("name", [*SIZES, *(c for columns in COLUMNS.values() for c in columns)])
def test_shapes_and_columns_stand_on_the_page(name):
    assert f"`{name}`" in PAGE

"""Why a case is refused, as one sentence: the key, what it was, what is allowed.

The models describe each field in words that complete "it must be …"; the sentences about wrong
types, sizes and counts are made from those words, so that a check and its message cannot part.
"""

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from smoothprofile.config.tomltext import inline
from smoothprofile.errors import CaseError

MISSING = object()
"""Stands for the value of a key that is not there."""

LONGEST_VALUE = 70
SAME_LETTERS = 4
WRONG_TABLE = 0.9
"""How like a key of another table a name must be to be taken for it, in the wrong place."""


class Refusal(CaseError):
    """A value that cannot be run; `key` is dotted and counts from the table that was checked."""

    def __init__(self, key: str, value: Any, allowed: str):
        self.key, self.value, self.allowed = key, value, allowed
        super().__init__(sentence(key, value, allowed))


def sentence(key: str, value: Any, allowed: str) -> str:
    """'key is value; allowed.'"""
    return f"{key} is {shown(value)}; {allowed}."


def shown(value: Any) -> str:
    """A value as TOML would spell it, cut short if it is long."""
    if value is MISSING:
        return "missing"
    text = inline(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 1] + "…"


def nearest(name: str, known: list[str], closeness: float = 0.6) -> str | None:
    """The known name most like `name`, if any is like it at all."""
    matches = get_close_matches(name, known, 1, closeness)
    return matches[0] if matches else None


def explain(error: ValidationError, data: Any, model: type[BaseModel], prefix: str = "") -> str:
    """The sentence for the first thing wrong with `data`; a misspelt key comes before the rest."""
    problems = error.errors(include_url=False)
    unknown = [problem for problem in problems if problem["type"] == "extra_forbidden"]
    problem = (unknown or problems)[0]
    path, table, description = _follow(model, problem["loc"])
    key = ".".join((*([prefix] if prefix else []), *path))
    if problem["type"] == "extra_forbidden":
        return _unknown_key(key, table, model)
    value = _look_up(data, path)
    cause = problem.get("ctx", {}).get("error")
    if isinstance(cause, Refusal):
        inner = ".".join(part for part in (key, cause.key) if part)
        return sentence(inner, cause.value, cause.allowed)
    if isinstance(cause, InnerError):
        place = [str(part) for part in problem["loc"]]
        return explain(cause.error, _look_up(data, place), cause.model, ".".join(place))
    if problem["type"] == "model_type" and table is not None:
        description = "a table with the keys " + ", ".join(table.model_fields)
    return sentence(key or "the case", value, f"it must be {description}")


class InnerError(ValueError):
    """The ValidationError of a table that one field may hold instead of a plain value."""

    def __init__(self, error: ValidationError, model: type[BaseModel]):
        self.error, self.model = error, model
        super().__init__(str(error))


def read_table(model: type[BaseModel], value: Any) -> BaseModel:
    """`value` as a table of that kind, for validators of fields that hold several kinds."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise InnerError(error, model) from None


def _unknown_key(key: str, table: type[BaseModel], root: type[BaseModel]) -> str:
    *parents, name = key.split(".")
    # What a terminal would not show as it is, or not on a line, is shown in quotes.
    plain = name and name.isprintable() and len(key) <= LONGEST_VALUE
    told = key if plain else shown(key)
    known = nearest(name, list(table.model_fields)) or _same_start(name, table)
    if known:
        return f"{told} is not a known key; the nearest is {'.'.join((*parents, known))}."
    everywhere = dict(_all_keys(root))
    elsewhere = nearest(name, list(everywhere), WRONG_TABLE)
    if elsewhere:
        return f"{told} is not a known key; the nearest is {everywhere[elsewhere]}."
    return f"{told} is not a known key; known here are {', '.join(table.model_fields)}."


def _same_start(name: str, table: type[BaseModel]) -> str | None:
    """The key of a table that begins as `name` does, if one alone does."""
    start = name[:SAME_LETTERS]
    found = [key for key in table.model_fields if key.startswith(start)]
    return found[0] if len(start) == SAME_LETTERS and len(found) == 1 else None


def _all_keys(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, str]]:
    """(name, dotted key) of every key of a model and of the tables inside it."""
    for name, field in model.model_fields.items():
        yield name, f"{path}{name}"
        inner = _table_in(field.annotation)
        if inner is not None:
            many = ".0" if get_args(field.annotation)[1:] == (...,) else ""
            yield from _all_keys(inner, f"{path}{name}{many}.")


def _table_in(annotation: Any) -> type[BaseModel] | None:
    """The model that a field of this type holds, alone, as an option or in a list."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_table_in, get_args(annotation))), None)


def _follow(model: type[BaseModel], location: tuple) -> tuple[list[str], Any, str]:
    """Path down to the key in question, the table it stands in or is, and its description.

    The path stops at a field that holds no tables: of three numbers the whole is shown, not one.
    """
    path, table, description = [], model, "a table"
    for part in location:
        if table is None:
            break
        path.append(str(part))
        if isinstance(part, str) and part in table.model_fields:
            field = table.model_fields[part]
            description, table = field.description, _table_in(field.annotation)
    return path, table, description


def _look_up(data: Any, path: list[str]) -> Any:
    for part in path:
        try:
            data = data[int(part) if isinstance(data, list) else part]
        except (KeyError, IndexError, ValueError, TypeError):
            return MISSING
    return data

"""From a name, a file or a dictionary to a case: find, parse, override, check."""

import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from smoothprofile.config import library
from smoothprofile.config.case import Case
from smoothprofile.config.refusals import Refusal, explain, shown
from smoothprofile.config.sources import expanded, unfilled
from smoothprofile.config.units import without_units
from smoothprofile.errors import CaseError

Overrides = Mapping[str, Any] | Iterable[str]

LARGEST_FILE = 64 * 2**20
DEEPEST = 12
# Forty dotted names in a row: the parser takes a time quadratic in their number.
LONG_KEY = re.compile(r"(?<![^\s.=,\[\]{}#])(?:[^\s.=,\[\]{}#]++[ \t]*+\.[ \t]*+){40}")
# .3 and 3. are no TOML, and what people type on a command line.
SIGNED_POINT = re.compile(r"[+-]?\.\d", re.ASCII)
SHORT_NUMBER = re.compile(r"[+-]?(\d+\.|\.\d+)([eE][+-]?\d+)?$", re.ASCII)
# What the parser says of a table and a key that are given twice, and where a key stands in a line.
QUOTED = r"'([^']*)'"
TABLE_TWICE = re.compile(r"cannot declare \((.*)\) twice")
INLINE_TWICE = re.compile(rf"duplicate inline table key {QUOTED}")
KEY_OF_LINE = re.compile(r"\s*([A-Za-z0-9_.\"'-]{1,60})\s*=")
WHERE = re.compile(r"^(.*) \(at (?:line (\d+), column (\d+)|end of document)\)$", re.DOTALL)


def load_case(source: str | os.PathLike | Mapping | Case, overrides: Overrides = ()) -> Case:
    """The case of a built-in name, a TOML file, a dictionary, or another case, with overrides.

    Overrides are "table.key=value" strings, their values TOML or else bare words, or a dictionary
    {"table.key": value}; particles.0.radius reaches into lists. A built-in name goes before a file
    of the same name. Files that a case names lie in the folder of its own file, or of a dictionary
    in the current one. CaseError, one sentence, for whatever cannot be run.
    """
    data, folder = without_units(_overridden(source, overrides)), _folder_of(source)
    if "numbers" in data:
        # Numbers are worked out from whole cases, so that what does it cannot be met before them.
        from smoothprofile.config.dimensionless import case_of_numbers

        case = case_of_numbers(data, partial(_checked, folder=folder))
    else:
        case = _checked(data, folder)
    names = library.reference_names()
    if case.reference is not None and case.reference not in names:
        raise Refusal("reference", case.reference, f"it must be one of {', '.join(names)}")
    return case


def seeds_of(source: Any, overrides: Overrides = ()) -> dict[str, int]:
    """Key and seed of whatever a case, given as for `load_case`, draws at random.

    Radii that a lattice or a file deals out by shares or a distribution have the seed 0.
    """
    data, found = _overridden(source, overrides), {}
    for k, entry in enumerate(data.get("particles", ())):
        if "random" in entry:
            found[f"particles.{k}.random"] = entry["random"].get("seed", 0)
        elif isinstance(entry.get("radius"), dict):
            found[f"particles.{k}.radius"] = 0
    return found


def unfilled_lattices(
    source: Any, overrides: Overrides = ()
) -> list[tuple[str, int, float, float]]:
    """Key, axis, extent and period of lattices that do not fill their box along periodic axes.

    Of a case, given as for `load_case`, that can be loaded.
    """
    return unfilled(without_units(_overridden(source, overrides)))


def _overridden(source: Any, overrides: Overrides) -> dict[str, Any]:
    """The plain data of a source with the overrides in it."""
    data = _plain(_data_of(source))
    for key, value in _pairs(overrides):
        _put(data, key, _plain(value, key))
    return data


def _checked(data: dict[str, Any], folder: Path) -> Case:
    """The case of plain data, its files in that folder."""
    data, origins = expanded(data, folder)
    try:
        return Case.model_validate(data)
    except ValidationError as error:
        sentence = explain(error, data, Case)
        raise CaseError(origins.told(sentence) if origins else sentence) from None


def _data_of(source: Any) -> dict[str, Any]:
    if isinstance(source, Case):
        return source.data()
    if isinstance(source, Mapping):
        return dict(source)
    if not isinstance(source, str | os.PathLike):
        kind = type(source).__name__
        raise CaseError(f"a case is a name, a path or a dictionary, not of type {kind}.")
    name = os.fspath(source)
    if not isinstance(name, str):
        raise CaseError(f"a path must be text, and {name!r} is not.")
    if name in library.case_names():
        return parse(library.case_path(name).read_text(encoding="utf-8"), name)
    bare = isinstance(source, str) and Path(name).name == name and not name.endswith(".toml")
    if bare and not os.path.lexists(name):
        library.case_path(name)
    return parse(_text_of(name), name)


def _folder_of(source: Any) -> Path:
    """Where the files lie that the case names."""
    named = isinstance(source, str | os.PathLike) and os.fspath(source) not in library.case_names()
    return Path(os.fspath(source)).parent if named else Path()


def _text_of(name: str) -> str:
    try:
        with open(name, "rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except IsADirectoryError:
        raise CaseError(f"{name} is a directory; a case is one TOML file.") from None
    except FileNotFoundError:
        raise CaseError(f"{name} does not exist; give a TOML file or a built-in case.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise CaseError(f"{shown(name)} cannot be read: {reason}.") from None
    if len(content) > LARGEST_FILE:
        raise CaseError(f"{name} is too large for a case: more than {LARGEST_FILE // 2**20} MiB.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        column = error.start - content.rfind(b"\n", 0, error.start)
        raise CaseError(
            f"{name} is not UTF-8 text at line {line}, column {column}, as TOML must be."
        ) from None


def parse(text: str, name: str) -> dict[str, Any]:
    """The tables of a TOML text; CaseError with the line and column of what is not TOML."""
    long_key = LONG_KEY.search(text)
    if long_key:
        line = text.count("\n", 0, long_key.start()) + 1
        raise CaseError(f"{name} is nested too deeply for a case, at line {line}.")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise CaseError(f"{name} is nested too deeply for a case.") from None
    except ValueError as error:
        where = WHERE.match(str(error))
        reason = (where[1] if where else str(error)).split(";")[0]
        line, column = (where[2], where[3]) if where else (None, None)
        if line is None:
            line, column = text.count("\n") + 1, len(text) - text.rfind("\n")
        reason = reason[:1].lower() + reason[1:]
        reason = _given_twice(reason, text.split("\n")[: int(line)]) or reason
        if SIGNED_POINT.match(text.split("\n")[int(line) - 1], int(column) - 1):
            reason = "a number needs a digit before its point, as in 0.5"
        raise CaseError(f"{name} is not TOML at line {line}, column {column}: {reason}.") from None


def _given_twice(reason: str, lines: list[str]) -> str | None:
    """Which key or table a text gives twice, its last line the one that the parser stopped at."""
    table = TABLE_TWICE.match(reason)
    if table:
        return f"the table [{'.'.join(re.findall(QUOTED, table[1]))}] is given twice"
    inline = INLINE_TWICE.match(reason)
    keys = filter(None, map(KEY_OF_LINE.match, reversed(lines)))
    key = next(keys, None) if reason == "cannot overwrite a value" else None
    name = inline[1] if inline else key and key[1]
    return name and f"the key {name} is given twice"


def _plain(value: Any, key: str = "", depth: int = 0) -> Any:
    """Dictionaries, lists and plain numbers only, copied; arrays become lists."""
    if depth > DEEPEST:
        raise CaseError(f"{key or 'the case'} is nested too deeply for a case.")
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                raise CaseError(f"{name!r} in {key or 'the case'} is no key; keys are texts.")
        inner = f"{key}." if key else ""
        return {n: _plain(v, f"{inner}{n}", depth + 1) for n, v in value.items() if v is not None}
    if isinstance(value, list | tuple):
        return [_plain(item, f"{key}.{i}", depth + 1) for i, item in enumerate(value)]
    if isinstance(value, str) and not value.isascii():
        try:
            value.encode("utf-8")
        except UnicodeEncodeError:
            raise CaseError(f"{key} is {value!a}; it must be UTF-8 text.") from None
    return value


def _pairs(overrides: Overrides) -> Iterable[tuple[str, Any]]:
    if isinstance(overrides, Mapping):
        yield from overrides.items()
        return
    for text in [overrides] if isinstance(overrides, str) else overrides:
        key, equals, value = text.partition("=")
        if not equals or not all(part.strip() for part in key.split(".")):
            raise CaseError(f"override {shown(text)} must be written as table.key=value.")
        yield key.strip(), _value(value.strip())


def _value(text: str) -> Any:
    """The text as a TOML value, or as a bare word if it is none."""
    try:
        table = parse(f"value = {text}", "an override")
    except CaseError:
        return float(text) if SHORT_NUMBER.match(text) else text
    return table["value"] if len(table) == 1 else text


def _put(data: dict[str, Any], key: str, value: Any) -> None:
    """data[a][b]… = value for the dotted key a.b…, making the tables on the way."""
    *parents, last = key.split(".")
    place: Any = data
    for depth, part in enumerate((*parents, last)):
        here = ".".join(parents[:depth])
        if isinstance(place, list):
            index = int(part) if part.isascii() and part.isdigit() and len(part) < 10 else -1
            if not 0 <= index < len(place):
                count = f"{len(place)} {'entry' if len(place) == 1 else 'entries'}, counted from 0"
                raise CaseError(f"override {key} does not fit: {here} has {count}.")
            part = index
        elif not isinstance(place, dict):
            raise CaseError(f"override {key} does not fit: {here} is {shown(place)}, not a table.")
        elif part.isdigit():
            raise CaseError(f"override {key} does not fit: this case sets no list {here}.")
        if depth == len(parents):
            place[part] = value
        else:
            place = place[part] if isinstance(place, list) else place.setdefault(part, {})

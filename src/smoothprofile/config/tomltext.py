"""TOML text from plain Python values: what `tomllib`, which only reads, leaves out.

Handles the values a case holds: tables with bare keys, lists, strings, numbers and booleans.
"""

import json
import re
from collections.abc import Mapping
from typing import Any

BARE = re.compile(r"[A-Za-z0-9_-]+")


def inline(value: Any) -> str:
    """One value on one line, as it stands after an equals sign."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON's escapes are TOML's, except that TOML also wants DEL escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{_key(key)} = {inline(item)}" for key, item in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(inline(item) for item in value)}]"
    return str(value)


def _key(name: str) -> str:
    """A key as it is written: quoted unless it is bare."""
    return name if BARE.fullmatch(name) else inline(name)


def document(table: Mapping[str, Any], path: tuple[str, ...] = ()) -> str:
    """A whole table: its plain values, then its tables and lists of tables; no empty tables."""
    plain, nested = [], []
    for key, value in table.items():
        name = ".".join((*path, key))
        if isinstance(value, Mapping) and value:
            nested.append(f"\n[{name}]\n" + document(value, (*path, key)))
        elif _is_list_of_tables(value):
            nested += [f"\n[[{name}]]\n" + document(item, (*path, key)) for item in value]
        elif not isinstance(value, Mapping):
            plain.append(f"{key} = {inline(value)}\n")
    return "".join(plain + nested)


def _is_list_of_tables(value: Any) -> bool:
    filled = isinstance(value, list | tuple) and bool(value)
    return filled and all(isinstance(item, Mapping) for item in value)

"""What several commands of `spm` take: arguments and options, with their help."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer


def whole_number(least: int) -> Callable[[Any], int]:
    """A reader of whole numbers from `least` on, for options."""

    def read(text: Any) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least:
            raise typer.BadParameter(f"is {text}; it must be a whole number from {least}")
        return number

    return read


CaseArgument = Annotated[
    str, typer.Argument(metavar="CASE", help="A TOML file, or a built-in case's name.")
]
RunArgument = Annotated[Path, typer.Argument(metavar="DIRECTORY", help="A run directory.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
JsonFile = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="Write the JSON object to a file.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="TABLE.KEY=VALUE", help="Change the case. May be given many times."
    ),
]
Retry = Annotated[
    int,
    typer.Option(
        metavar="N",
        parser=whole_number(0),
        help="After a blow-up go back and halve the step, N times.",
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        parser=whole_number(1),
        help="Threads to use; if left out, what proves fastest.",
    ),
]

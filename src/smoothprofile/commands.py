"""How `spm` refuses a line that it cannot read: in one sentence, with exit code 2."""

import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from smoothprofile.console import leave
from smoothprofile.errors import CaseError

UsageError = typer.BadParameter.__base__
"""Click's, or that of the copy of click which newer versions of typer have."""


EXTRA = re.compile(r"Got unexpected extra argument(?:s|\(s\))? \((.*)\)", re.DOTALL)


class Commands(TyperGroup):
    """The commands of `spm`, each of whose wrong uses is told as wrong input is."""

    def main(self, args: Sequence[str] | None = None, **settings: Any) -> NoReturn:
        """Run the line and leave with its exit code; without any words, show the help."""
        words = sys.argv[1:] if args is None else list(args)
        settings |= {"prog_name": "spm", "standalone_mode": not words}
        try:
            sys.exit(super().main(words, **settings))
        except CaseError as error:
            told: BaseException = error
        except UsageError as error:
            told = CaseError(_sentence(error))
        except typer.Abort:
            told = KeyboardInterrupt()
        try:
            leave(told, "--json" in words)
        except typer.Exit as end:
            sys.exit(end.exit_code)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """As typer's; CaseError with the nearest command for a name that is none."""
        if args[0] not in self.commands:
            raise CaseError(_unknown("spm has no command", args[0], list(self.commands)))
        return super().resolve_command(ctx, args)


def _sentence(error: Any) -> str:
    """What is wrong with a line: of an option or argument its name, its value, what is allowed."""
    line = error.ctx.command_path if error.ctx else "spm"
    option, parameter = getattr(error, "option_name", None), getattr(error, "param", None)
    if option is not None and error.ctx is not None and hasattr(error, "possibilities"):
        known = [max(p.opts, key=len) for p in error.ctx.command.params if p.opts[0][0] == "-"]
        return _unknown(f"{line} has no option", option, known)
    if isinstance(error, typer.BadParameter) and parameter is not None:
        if error.message:
            return f"{max(parameter.opts, key=len)} {error.message}."
        return f"{line} needs {parameter.metavar}: {_begun_small(parameter.help)}"
    extra = EXTRA.match(error.format_message())
    if extra and error.ctx is not None:
        known = [p.metavar for p in error.ctx.command.params if p.opts[0][0] != "-"]
        return f"{line} takes {' and '.join([*known, 'options'])} alone; {extra[1]} is too much."
    return f"{line}: {_begun_small(error.format_message().rstrip('.'))}."


def _begun_small(text: str) -> str:
    return f"{text[:1].lower()}{text[1:]}"


def _unknown(what: str, name: str, known: list[str]) -> str:
    # Loaded for a mistake alone: with it come all models of a case.
    from smoothprofile.config.refusals import nearest

    like = nearest(name, known)
    return f"{what} {name}; " + (
        f"the nearest is {like}." if like else f"it has {', '.join(known)}."
    )

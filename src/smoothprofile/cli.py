"""The command `spm`.

Each command imports what it needs when it is called, so that help comes at once.
"""

import signal
from pathlib import Path
from typing import Annotated

import typer

from smoothprofile.arguments import (
    CaseArgument,
    Json,
    JsonFile,
    Retry,
    RunArgument,
    Settings,
    Threads,
    whole_number,
)
from smoothprofile.commands import Commands
from smoothprofile.console import answer, check_free, exit_codes, print_json, print_table, say

app = typer.Typer(
    cls=Commands,
    help="Particles in incompressible flow by the smoothed profile method.",
    epilog="Begin with: spm cases, then spm run duct.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    add_completion=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from smoothprofile import __version__

        typer.echo(f"smoothprofile {__version__}")
        raise typer.Exit


@app.callback()
def spm(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Particles in incompressible flow by the smoothed profile method."""


@app.command("cases")
def cases_command(out: JsonFile = None, json: Json = False) -> None:
    """List the built-in cases."""
    with exit_codes(json):
        from smoothprofile import cases

        entries = cases.list_cases()
        if answer({"cases": [entry._asdict() for entry in entries]}, json, out):
            rows = [(entry.name, entry.takes, entry.description) for entry in entries]
            print_table("Built-in cases", ("name", "takes", "what it is"), rows)
            say("spm run NAME runs one; spm new NAME writes it out to edit. Times are of one core.")


@app.command()
def new(
    case: Annotated[str, typer.Argument(metavar="NAME", help="A built-in case's name.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The file to write; NAME.toml if left out."),
    ] = None,
    json: Json = False,
) -> None:
    """Write a built-in case to a file, to edit."""
    with exit_codes(json):
        from smoothprofile import cases

        text = cases.case_path(case).read_text(encoding="utf-8")
        target = out or Path(f"{case}.toml")
        check_free(target)
        target.write_text(text, encoding="utf-8")
        if json:
            print_json({"file": str(target)})
        else:
            say(f"Wrote {target}. Edit it, then: spm check {target}, spm run {target}.")


@app.command()
def check(
    case: CaseArgument,
    set_: Settings = None,
    threads: Threads = None,
    out: JsonFile = None,
    json: Json = False,
) -> None:
    """Say what a case amounts to, before hours are spent on it."""
    with exit_codes(json):
        from smoothprofile.config import load_case
        from smoothprofile.gap_checks import lattice_rows
        from smoothprofile.numbers import number_rows, numbers_of
        from smoothprofile.runs import run_of

        check_free(out)
        loaded = load_case(case, set_ or [])
        _use(threads)
        rows, title = run_of(loaded).preflight(), loaded.title
        rows += lattice_rows(case, set_ or [])
        if answer({"title": title, "checks": rows, "numbers": numbers_of(loaded)}, json, out):
            heads = ("check", "value", "limit or best", "verdict", "note")
            print_table(title, heads, [tuple(row.values()) for row in rows])
            print_table("What it amounts to", ("number", "value", ""), number_rows(loaded))


@app.command()
def run(
    case: CaseArgument,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIRECTORY", help="The run directory, which is made; runs/CASE if left out."
        ),
    ] = None,
    set_: Settings = None,
    threads: Threads = None,
    resume: Annotated[
        bool,
        typer.Option("--resume-if-exists", help="Go on if the run directory is there already."),
    ] = False,
    retry: Retry = 0,
    json: Json = False,
) -> None:
    """Run a case; ends with a table and a report."""
    with exit_codes(json):
        from smoothprofile.running import start, start_or_go_on

        _use(threads)
        if resume:
            start_or_go_on(case, set_ or [], out, json, retry)
            return
        check_free(out, "output directory")
        start(case, set_ or [], out, json, retry)


@app.command()
def resume(
    directory: RunArgument,
    retry: Retry = 0,
    threads: Threads = None,
    json: Json = False,
) -> None:
    """Go on with a run that was stopped or killed, exactly where its last checkpoint is."""
    with exit_codes(json):
        from smoothprofile.running import go_on

        _use(threads)
        go_on(directory, json, retry)


@app.command()
def rerun(
    directory: RunArgument,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIRECTORY", help="The new one; DIRECTORY-again if left out."),
    ] = None,
    threads: Threads = None,
    json: Json = False,
) -> None:
    """Repeat a run that has ended, and compare the two bit by bit."""
    with exit_codes(json):
        from smoothprofile.running import repeat

        check_free(out, "output directory")
        _use(threads)
        repeat(directory, out, json)


@app.command()
def report(
    directory: RunArgument,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The page to write; report.html there if left out."),
    ] = None,
    json: Json = False,
) -> None:
    """Rebuild the report of a run from its directory."""
    with exit_codes(json):
        from smoothprofile.report import write_report

        check_free(out)
        path = write_report(directory, out)
        if json:
            print_json({"report": str(path)})
        else:
            say(f"Wrote {path}.")


@app.command()
def film(
    directory: RunArgument,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="An .mp4 or .gif to write; film.mp4 there if left out."),
    ] = None,
    json: Json = False,
) -> None:
    """Film the beads of a run."""
    with exit_codes(json):
        from smoothprofile.film import write_film

        check_free(out)
        path = write_film(directory, out)
        if json:
            print_json({"film": str(path)})
        else:
            say(f"Wrote {path}.")


@app.command()
def study(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="A study's name, or list, or all of them: all.")
    ] = "list",
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIRECTORY",
            help="Where to write; studies/NAME if left out, and with list a JSON file.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Repeat an experiment of the thesis: its numbers, the exact ones and ours."""
    with exit_codes(json):
        from smoothprofile.studies import STUDIES, TAKES, study_named
        from smoothprofile.studying import chosen, run_study

        if name == "list":
            rows = [(key, TAKES[key], text) for key, text in STUDIES.items()]
            heads = ("name", "takes", "description")
            entries = [dict(zip(heads, row, strict=True)) for row in rows]
            if answer({"studies": entries}, json, out):
                print_table("Studies", ("name", "takes", "what it is"), rows)
                say("spm study NAME runs one; spm study all runs them all.")
            return
        names = chosen(name)
        for key in names:
            study_named(key)
        check_free(out, "output directory")
        found = [run_study(key, out / key if out and name == "all" else out, json) for key in names]
        if json:
            print_json(found[0] if name != "all" else {"studies": found})
        if not all(entry["agrees"] for entry in found):
            say("Some numbers differ from what they should be: see the verdicts.")
            raise typer.Exit(3)


@app.command()
def bench(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="What to time; its first steps are run.")
    ] = "duct",
    cells: Annotated[str, typer.Option(metavar="NX,NY,NZ", help="The grid.")] = "256,90,90",
    set_: Settings = None,
    threads: Annotated[
        int | None,
        typer.Option(metavar="N", parser=whole_number(1), help="Threads to use; all if left out."),
    ] = None,
    out: JsonFile = None,
    json: Json = False,
) -> None:
    """Speed and memory of a step, beside an FFT round trip and a memory copy."""
    with exit_codes(json):
        from smoothprofile.bench import measure
        from smoothprofile.threads import available_threads

        check_free(out)
        _use(available_threads() if threads is None else threads)
        found = measure(case, [f"domain.cells=[{cells}]", "start=[]", *(set_ or [])])
        if answer(found, json, out):
            print_table("Speed and memory", ("quantity", "value"), list(found.items()))


@app.command()
def doctor(out: JsonFile = None, json: Json = False) -> None:
    """Versions, threads, and a self-test."""
    with exit_codes(json):
        from smoothprofile.doctor import examine

        check_free(out)
        found = examine()
        if answer(found, json, out):
            rows = [(name, value) for name, value in found.items() if name != "tests"]
            print_table("Installation", ("what", "which"), rows)
            heads = ("self-test", "measured", "limit", "verdict")
            print_table("", heads, [tuple(test.values()) for test in found["tests"]])
        if any(test["verdict"] != "ok" for test in found["tests"]):
            raise typer.Exit(3)


def _use(threads: int | None) -> None:
    """Set the number of threads that is asked for; without one, runs find the fastest."""
    from smoothprofile.threads import set_thread_count

    if threads is not None:
        set_thread_count(threads)


def main() -> None:
    """Entry point of `spm`."""
    # What asks a process to end, ends it as Ctrl-C does: files closed, status written.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    app()

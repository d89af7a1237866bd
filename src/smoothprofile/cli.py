"""The command `spm`."""

from pathlib import Path
from typing import Annotated

import typer

from smoothprofile import __version__, cases
from smoothprofile.bench import measure
from smoothprofile.config import load_case
from smoothprofile.console import Watcher, exit_codes, print_json, print_table, say
from smoothprofile.doctor import examine
from smoothprofile.errors import CaseError
from smoothprofile.output import RunDirectory, next_free_directory
from smoothprofile.report import write_report
from smoothprofile.simulation import Simulation
from smoothprofile.threads import available_threads, set_thread_count

app = typer.Typer(
    help="Particles in incompressible flow by the smoothed profile method.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    add_completion=False,
)

CaseArgument = Annotated[str, typer.Argument(help="A TOML file, or a built-in case's name.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", help="Change the case: table.key=value. May be given many times."),
]
Threads = Annotated[
    int | None, typer.Option(help="Threads to use; all of the machine's if left out.")
]


@app.command("cases")
def cases_command(json: Json = False) -> None:
    """List the built-in cases."""
    with exit_codes(json):
        entries = cases.list_cases()
        if json:
            print_json({"cases": [entry._asdict() for entry in entries]})
            return
        print_table(
            "Built-in cases", ("name", "what it is"), [(e.name, e.description) for e in entries]
        )
        say("spm run NAME runs one; spm new NAME writes it out to edit.")


@app.command()
def new(
    case: Annotated[str, typer.Argument(help="A built-in case's name.")],
    out: Annotated[
        Path | None, typer.Option(help="The file to write; NAME.toml if left out.")
    ] = None,
    json: Json = False,
) -> None:
    """Write a built-in case to a file, to edit."""
    with exit_codes(json):
        text = cases.case_path(case).read_text(encoding="utf-8")
        target = out or Path(f"{case}.toml")
        if target.exists():
            raise CaseError(f"the file {target} exists already; nothing was overwritten.")
        target.write_text(text, encoding="utf-8")
        if json:
            print_json({"file": str(target)})
        else:
            say(f"Wrote {target}. Edit it, then: spm check {target}, spm run {target}.")


@app.command()
def check(
    case: CaseArgument, set_: Settings = None, threads: Threads = None, json: Json = False
) -> None:
    """Say what a case amounts to, before hours are spent on it."""
    with exit_codes(json):
        _use(threads)
        simulation = Simulation(load_case(case, set_ or []))
        rows = simulation.preflight()
        if json:
            print_json({"title": simulation.case.title, "checks": rows})
            return
        heads = ("check", "value", "limit or best", "verdict", "note")
        print_table(simulation.case.title, heads, [tuple(row.values()) for row in rows])


@app.command()
def run(
    case: CaseArgument,
    out: Annotated[
        Path | None, typer.Option(help="The run directory; runs/NAME if left out.")
    ] = None,
    set_: Settings = None,
    threads: Threads = None,
    json: Json = False,
) -> None:
    """Run a case; ends with a table and a report."""
    with exit_codes(json):
        _use(threads)
        simulation = Simulation(load_case(case, set_ or []))
        for row in simulation.preflight():
            if row["verdict"] == "warn":
                say("Note: {name} is {value:.3g}, against {limit:.3g}: {note}.".format(**row))
        path = out or next_free_directory("runs", Path(case).stem)
        resolved = simulation.case.to_toml()
        with (
            RunDirectory(path, resolved, simulation.preflight()) as directory,
            Watcher(quiet=json) as watcher,
        ):

            def observe(running: Simulation) -> None:
                watcher(running)
                if running is simulation:
                    directory.record(running)

            simulation.run(observe)
            summary = directory.finish(simulation)
        report_path = write_report(path)
        if json:
            print_json({**summary, "directory": str(path), "report": str(report_path)})
            return
        print_table(simulation.case.title, ("quantity", "value", ""), simulation.table())
        say(f"Everything is in {path}; open {report_path}.")


@app.command()
def report(
    directory: Annotated[Path, typer.Argument(help="A run directory.")], json: Json = False
) -> None:
    """Rebuild the report of a run from its directory."""
    with exit_codes(json):
        path = write_report(directory)
        if json:
            print_json({"report": str(path)})
        else:
            say(f"Wrote {path}.")


@app.command()
def bench(
    case: Annotated[
        str, typer.Argument(help="What to time: a case; its first steps are run.")
    ] = "duct",
    cells: Annotated[str, typer.Option(help="The grid, as 256,90,90.")] = "256,90,90",
    set_: Settings = None,
    threads: Threads = None,
    json: Json = False,
) -> None:
    """Speed and memory, as ratios to an FFT round trip and a memory copy in the same process."""
    with exit_codes(json):
        _use(threads)
        found = measure(case, [f"domain.cells=[{cells}]", "start=[]", *(set_ or [])])
        if json:
            print_json(found)
            return
        print_table("Speed and memory", ("quantity", "value"), list(found.items()))


@app.command()
def doctor(json: Json = False) -> None:
    """Versions, threads, and a self-test."""
    with exit_codes(json):
        found = examine()
        if json:
            print_json(found)
        else:
            rows = [(k, v) for k, v in found.items() if k != "tests"]
            print_table(f"smoothprofile {__version__}", ("", ""), rows)
            heads = ("self-test", "measured", "limit", "verdict")
            print_table("", heads, [tuple(test.values()) for test in found["tests"]])
        if any(test["verdict"] != "ok" for test in found["tests"]):
            raise typer.Exit(3)


def _use(threads: int | None) -> None:
    set_thread_count(threads if threads is not None else available_threads())


def main() -> None:
    """Entry point of `spm`."""
    app()

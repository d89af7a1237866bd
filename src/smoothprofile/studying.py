"""What `spm study` does with one study."""

from pathlib import Path

from smoothprofile import studies
from smoothprofile.console import print_table, say
from smoothprofile.output import next_free_directory
from smoothprofile.studies.directory import as_dict, corrections, shown, write_study
from smoothprofile.studies.study import HEADS


def chosen(name: str) -> list[str]:
    """The study of that name; of "all", those whose needs are installed, telling of the others."""
    if name != "all":
        return [name]
    names = [key for key in studies.STUDIES if studies.can_run(key)]
    for key in studies.STUDIES.keys() - names:
        say(f"{key} is left out: it needs {studies.NEEDS[key]}, which is not installed.")
    return names


def run_study(name: str, out: Path | None, json: bool) -> dict:
    """Run one study into a directory, tell what it found, and return that as plain data."""
    if not json:
        say(f"Running {name} …")
    directory = out or next_free_directory("studies", name)
    # Before a study takes its minutes, so that they are not lost where nothing can be written.
    directory.mkdir(parents=True)
    try:
        done = studies.study_named(name)()
    except BaseException:
        directory.rmdir()
        raise
    report = write_study(done, directory)
    if not json:
        # Remarks would leave the numbers no room on a terminal: they follow, and are in the report.
        heads = tuple(head.replace(" or ", " or\n") for head in HEADS[:-1])
        print_table(done.title, heads, [shown(row)[:-1] for row in done.rows], folds=HEADS[0])
        for text in (*done.findings, *corrections(done)):
            say(f"• {text}")
        say(f"Everything is in {directory}; open {report}.")
    return {**as_dict(done), "directory": str(directory), "report": str(report)}

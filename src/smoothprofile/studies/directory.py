"""A study on disk: table, curves and figures, and a page that shows them."""

import csv
from html import escape
from pathlib import Path

from smoothprofile import webpage
from smoothprofile.jsontext import to_json
from smoothprofile.studies.study import AGREES, HEADS, NEW, Row, Study


def write_study(study: Study, directory: Path) -> Path:
    """table.csv, a CSV file for each set of curves, figures/*.png, study.json and report.html.

    The directory is made if need be; FileExistsError if it holds figures already. Returns the
    report's path.
    """
    (directory / "figures").mkdir(parents=True)
    _write_csv(directory / "table.csv", HEADS, [row.cells() for row in study.rows])
    for name, columns in study.curves.items():
        rows = zip(*(values.tolist() for values in columns.values()), strict=True)
        _write_csv(directory / f"{name}.csv", list(columns), rows)
    for picture in study.pictures:
        (directory / "figures" / f"{picture.name}.png").write_bytes(picture.png)
    (directory / "study.json").write_text(to_json(as_dict(study)), encoding="utf-8")
    report = directory / "report.html"
    report.write_text(_page(study), encoding="utf-8")
    return report


def as_dict(study: Study) -> dict:
    """The study without its curves and figures."""
    return {
        "title": study.title,
        "source": study.source,
        "agrees": study.agrees,
        "findings": list(study.findings),
        "table": [dict(zip(HEADS, row.cells(), strict=True)) for row in study.rows],
    }


def shown(row: Row) -> list[str]:
    """The cells of a row as text: six digits, of the difference two."""
    texts = [
        _text(cell, 2 if head == "difference" else 6)
        for head, cell in zip(HEADS, row.cells(), strict=True)
    ]
    return [*texts[:-1], row.remark]


def corrections(study: Study) -> list[str]:
    """What is to be said of the numbers that the thesis prints otherwise."""
    return [
        f"{row.quantity}: the thesis has {_text(row.thesis, 6)}. {row.remark}"
        for row in study.rows
        if isinstance(row.thesis, float)
        and row.remark
        and abs(row.thesis - row.ours) > row.tolerance
    ]


def _text(cell: float | str | None, digits: int) -> str:
    if isinstance(cell, float):
        return f"{cell:.{digits}g}".replace("-", "−")
    return "–" if cell is None else str(cell)


def _page(study: Study) -> str:
    compared = [row for row in study.rows if row.verdict != NEW]
    agreeing = sum(row.verdict == AGREES for row in compared)
    verdict = webpage.badge(
        "ok" if study.agrees else "failed", f"{agreeing} of {len(compared)} numbers agree"
    )
    rows = [shown(row) for row in study.rows]
    findings = "".join(f"<li>{escape(text)}</li>" for text in study.findings)
    sections = [
        f"<p>{escape(study.introduction)}</p>",
        webpage.section("Findings", f"<ul>{findings}</ul>" if findings else ""),
        webpage.section("Numbers", webpage.table(HEADS, rows, numbers={1, 2, 3, 4})),
        webpage.section("Figures", webpage.figures(study.pictures)),
    ]
    status = verdict + f'<span class="faint">{escape(study.source)}</span>'
    return webpage.page(study.title, status, sections)


def _write_csv(path: Path, heads, rows) -> None:
    with path.open("x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(rows)

"""HTML of reports: one page that needs nothing else, its sections, tables and figures."""

import base64
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from smoothprofile.figures import Picture

VERDICTS = {
    "finished": "good",
    "steady": "good",
    "ok": "good",
    "agrees": "good",
    "new": "plain",
    "differs": "bad",
    "blew_up": "bad",
    "failed": "bad",
    "refuse": "bad",
    "green": "good",
    "red": "bad",
}

_PAGE = Template(files("smoothprofile").joinpath("page.html").read_text(encoding="utf-8"))


def page(title: str, status: str, sections: Iterable[str]) -> str:
    """The whole page; status is HTML, empty sections are left out."""
    return _PAGE.substitute(
        title=escape(title), status=status, sections="\n".join(filter(None, sections))
    )


def badge(verdict: str, text: str) -> str:
    """A word in the colour of its verdict."""
    return f'<span class="badge {VERDICTS.get(verdict, "warn")}">{escape(text)}</span>'


def figures(drawn: Sequence[Picture]) -> str:
    """All figures with their captions, two abreast unless wide."""
    if not drawn:
        return ""
    return f'<div class="figures">{"".join(map(_figure, drawn))}</div>'


def _figure(picture: Picture) -> str:
    shape, caption = "wide" if picture.wide else "half", escape(picture.caption)
    source = f"data:image/png;base64,{base64.b64encode(picture.png).decode('ascii')}"
    image = f'<img alt="{caption}" src="{source}">'
    return f'<figure class="{shape}">{image}<figcaption>{caption}</figcaption></figure>'


def section(title: str, content: str) -> str:
    """A titled section; nothing if it has no content."""
    return f"<section><h2>{escape(title)}</h2>{content}</section>" if content else ""


def details(title: str, content: str) -> str:
    """A section that opens on a click."""
    return f"<details><summary>{escape(title)}</summary>{content}</details>"


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], numbers: set[int]) -> str:
    """An HTML table; columns listed in `numbers` stand to the right, verdicts in their colour."""
    rows = list(rows)
    if not rows:
        return ""

    def cell(tag: str, column: int, text: str) -> str:
        kinds = ["number"] if column in numbers else []
        if tag == "td" and heads[column] == "verdict":
            kinds.append(VERDICTS.get(text, "warn"))
        return f'<{tag} class="{" ".join(kinds)}">{escape(text)}</{tag}>'

    def line(tag: str, texts: Sequence[str]) -> str:
        return f"<tr>{''.join(cell(tag, n, text) for n, text in enumerate(texts))}</tr>"

    head = f"<thead>{line('th', heads)}</thead>" if any(heads) else ""
    body = "".join(line("td", row) for row in rows)
    return f'<div class="scroll"><table>{head}<tbody>{body}</tbody></table></div>'


def words(name: str) -> str:
    """A name in plain words."""
    return name.replace("_", " ")


def number(value: Any, largest: float = 0.0) -> str:
    """Five digits, a real minus sign, nothing as a dash; a vector in brackets without round-off.

    largest: of the kind, where that is more than the vector's own.
    """
    if value is None:
        return "–"
    if isinstance(value, list | tuple):
        least = 1e-9 * max([largest, *(abs(part or 0) for part in value)])
        parts = [0 if part is not None and abs(part) < least else part for part in value]
        return f"({', '.join(map(number, parts))})"
    if isinstance(value, bool | str):
        return str(value)
    text = f"{value:,}" if isinstance(value, int) else f"{value:.5g}"
    return text.replace("-", "−").replace(",", "\u202f")


def percent(value: float | None, exact: float) -> str:
    """How far value lies from exact, in per cent of exact; a dash where that has no meaning."""
    if value is None or not exact:
        return "–"
    return f"{100 * (value / exact - 1):+.2f} %".replace("-", "−")


def with_percent(value: float | None, exact: float) -> str:
    """The number, with its distance from exact in per cent in brackets."""
    share = percent(value, exact)
    return number(value) + ("" if share == "–" else f" ({share})")

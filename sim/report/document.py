# SPDX-License-Identifier: Apache-2.0
"""Builds one HTML page that needs nothing else: no network, no second file.

A page is a list of parts in the order in which they are added. Interactive figures are Plotly's;
its library is put into the page once, from the installed package. The page forbids its own loading
of anything from elsewhere (Content-Security-Policy), so a part that tried would fail visibly.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs
from rich.console import Console
from rich.table import Table
from rich.text import Text

from asip_asm.files import write_text

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
       max-width: 64rem; margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; line-height: 1.2; } h2 { font-size: 1.3rem; margin-top: 2.5rem; }
table { border-collapse: collapse; }
caption { text-align: left; font-weight: 600; padding-bottom: .4rem; }
th, td { border-bottom: 1px solid #ccc; padding: .2rem .8rem; text-align: right; }
th { vertical-align: bottom; }
th:first-child, td:first-child, .left { text-align: left; }
tr.ours td { font-weight: 600; } tr.end td { border-bottom: 2px solid #666; }
.beyond { color: #b00020; font-weight: 700; }
.wide { overflow-x: auto; margin: 1.5rem 0 .3rem; }
.note, figcaption { color: #333; max-width: 48rem; margin: .2rem 0 1rem; }
figure { margin: 1rem 0 1.5rem; }
.key { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1rem 0; }
.key div { border: 1px solid #ccc; border-radius: .4rem; padding: .5rem 1rem; flex: 1 1 10rem; }
.key b { display: block; font-size: 1.4rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1.2rem; }
dt { font-weight: 600; } dd { margin: 0; overflow-wrap: anywhere; }
pre { overflow-x: auto; background: #f5f5f5; padding: .8rem; font-size: .85rem; line-height: 1.35; }
summary { cursor: pointer; font-weight: 600; margin: .8rem 0; }
@media (max-width: 40rem) {
  dl { grid-template-columns: 1fr; } dd { margin-bottom: .5rem; }
  th, td { padding: .15rem .45rem; font-size: .9rem; }
}
"""
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
# Without the button that would send a figure to a server.
CONFIG = {
    "responsive": True,
    "displaylogo": False,
    "modeBarButtonsToRemove": ["sendChartToCloud"],
}
SQUARE = """
(plot => {
  const height = Math.min(plot.clientWidth, plot.clientHeight);
  plot.style.height = height + 'px';
  Plotly.relayout(plot, {height: height});
})(document.getElementById('{plot_id}'));
"""
RED = "red"  # style of what is beyond its bound, in a table's row or in the markup of a cell


class Page:
    """A page that is being written, part by part; `write` puts it into a file."""

    def __init__(self, title: str, lead: str) -> None:
        """title: heading and name of the page; lead: what it shows, a sentence or two."""
        self._title = title
        self._parts = [f"<h1>{html.escape(title)}</h1><p>{html.escape(lead)}</p>"]
        self._figures = 0

    def section(self, heading: str, sentence: str = "") -> None:
        """A heading, and what follows it in a sentence."""
        text = f"<p>{html.escape(sentence)}</p>" if sentence else ""
        self._parts.append(f"<h2>{html.escape(heading)}</h2>{text}")

    def key_figures(self, figures: Mapping[str, str]) -> None:
        """The few results that a reader looks for first: what -> value with its unit."""
        boxes = "".join(
            f"<div><b>{html.escape(value)}</b>{html.escape(name)}</div>"
            for name, value in figures.items()
        )
        self._parts.append(f'<div class="key">{boxes}</div>')

    def alarm(self, sentence: str, cases: Sequence[str]) -> None:
        """What is not as it must be: a sentence, and each case."""
        items = "".join(f"<li>{html.escape(case)}</li>" for case in cases)
        self._parts.append(f'<div class="beyond">{html.escape(sentence)}<ul>{items}</ul></div>')

    def facts(self, facts: Mapping[str, str]) -> None:
        """A list of name and value."""
        rows = "".join(
            f"<dt>{html.escape(name)}</dt><dd>{html.escape(value)}</dd>"
            for name, value in facts.items()
        )
        self._parts.append(f"<dl>{rows}</dl>")

    def figure(
        self, figure: go.Figure, caption: str, square: bool = False, least_width: int = 0
    ) -> None:
        """An interactive figure with a sentence below it.

        square: never higher than it is wide; least_width: a narrower window scrolls it [px].
        """
        self._figures += 1
        drawn = figure.to_html(
            include_plotlyjs=False,
            full_html=False,
            config=CONFIG,
            div_id=f"figure-{self._figures}",
            post_script=SQUARE if square else None,
        )
        self._parts.append(
            f'<figure><div class="wide"><div style="min-width: {least_width}px">{drawn}</div></div>'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        )

    def table(self, table: Table) -> None:
        """A table as printed on the console, its caption as a sentence below it."""
        self._parts.append(_table(table))

    def text(self, summary: str, text: str) -> None:
        """A file's text, folded away under its summary."""
        self._parts.append(
            f"<details><summary>{html.escape(summary)}</summary>"
            f"<pre>{html.escape(text)}</pre></details>"
        )

    def folded(self, summary: str, table: Table) -> None:
        """A long table, folded away under its summary."""
        self._parts.append(
            f"<details><summary>{html.escape(summary)}</summary>{_table(table)}</details>"
        )

    def write(self, file: Path) -> None:
        """Write the page, the library of its figures included if it has any."""
        library = f"<script>{get_plotlyjs()}</script>" if self._figures else ""
        write_text(
            file,
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{html.escape(self._title)}</title><style>{STYLE}</style>{library}"
            f"</head><body>{''.join(self._parts)}</body></html>\n",
        )


def _cell(text: object, tag: str, left: bool) -> str:
    shown = text if isinstance(text, Text) else Console().render_str(str(text))
    names = ["left"] if left else []
    if any(RED in str(span.style) for span in shown.spans):
        names.append("beyond")
    mark = f' class="{" ".join(names)}"' if names else ""
    return f"<{tag}{mark}>{html.escape(shown.plain.replace(chr(10), ' '))}</{tag}>"


def _table(table: Table) -> str:
    left = [column.justify == "left" for column in table.columns]

    def cells(row: tuple[object, ...], tag: str) -> str:
        return "".join(_cell(text, tag, side) for text, side in zip(row, left, strict=True))

    head = cells(tuple(column.header for column in table.columns), "th")
    rows = []
    for row, content in zip(
        table.rows, zip(*(column.cells for column in table.columns), strict=True), strict=True
    ):
        names = ["ours"] if "bold" in str(row.style or "") else []
        names += ["beyond"] if RED in str(row.style or "") else []
        names += ["end"] if row.end_section else []
        mark = f' class="{" ".join(names)}"' if names else ""
        rows.append(f"<tr{mark}>{cells(content, 'td')}</tr>")
    note = f'<p class="note">{html.escape(str(table.caption))}</p>' if table.caption else ""
    title = Console().render_str(str(table.title or "")).plain
    return (
        f'<div class="wide"><table><caption>{html.escape(title)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>{note}"
    )

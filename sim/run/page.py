# SPDX-License-Identifier: Apache-2.0
"""One self-contained HTML page with the tables and plots of a run."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1.5rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .4rem; }
th, td { border-bottom: 1px solid #ccc; padding: .2rem .8rem; text-align: right; }
th:first-child, td:first-child { text-align: left; }
img { max-width: 100%; }
"""
MEDIA = {".png": "image/png", ".svg": "image/svg+xml"}


def _table(table: Table) -> str:
    console = Console()

    def plain(text: object) -> str:
        return html.escape(console.render_str(str(text)).plain.replace("\n", " "))

    head = "".join(f"<th>{plain(column.header)}</th>" for column in table.columns)
    rows = "".join(
        "<tr>" + "".join(f"<td>{plain(cell)}</td>" for cell in row) + "</tr>"
        for row in zip(*(column.cells for column in table.columns), strict=True)
    )
    return f"<table><caption>{plain(table.title)}</caption><tr>{head}</tr>{rows}</table>"


def write(file: Path, title: str, tables: Sequence[Table], plots: Sequence[Path]) -> None:
    """Write the page; plots (PNG or SVG) are embedded."""
    pictures = "".join(
        f'<p><img alt="{plot.stem}" src="data:{MEDIA[plot.suffix]};base64,'
        f'{base64.b64encode(plot.read_bytes()).decode()}"></p>'
        for plot in plots
    )
    file.write_text(
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}'
        f"</title><style>{STYLE}</style></head><body><h1>{html.escape(title)}</h1>"
        f"{''.join(map(_table, tables))}{pictures}</body></html>\n",
        encoding="utf-8",
    )

# SPDX-License-Identifier: Apache-2.0
"""Results as a notebook shows them: a table with a picture, and the interactive page."""
from __future__ import annotations

import base64
import os
import tempfile
import warnings
from html import escape
from typing import Any, Callable, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from . import _core
from ._common import Array, Error, Path, Topology, whole, written

SIZE = (640, 400, False)  # of a picture, without a caption; shown at half of that
Facts = List[Tuple[str, str]]


def number(value: float, units: str = '') -> str:
    return f'{value:.4g} {units}'.rstrip()


def ranged(values: Array, units: str = '') -> str:
    """'0.5 to 3 mm' of those that are finite; 'none' without any."""
    finite = np.asarray(values, float)
    finite = finite[np.isfinite(finite)]
    if not len(finite):
        return 'none'
    return number(finite.min()) + ' to ' + number(finite.max(), units)


def counted(count: int, one: str, several: Optional[str] = None) -> str:
    return f'{count:,} {one if count == 1 else several or one + "s"}'


def topology_text(topology: Topology, dimension: int) -> str:
    components, loops, cavities = topology.betti
    text = f'{counted(components, "component")}, {counted(loops, "hole" if dimension == 2 else "tunnel")}'
    return text if dimension == 2 else f'{text}, {counted(cavities, "cavity", "cavities")}'


def box_text(vertices: Array, units: str) -> str:
    """The box of points: 'x 2 to 40, y 1 to 9 mm'."""
    if not len(vertices):
        return 'none'
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    sides = [f'{name} {number(a)} to {number(b)}' for name, a, b in zip('xyz', low, high)]
    return f'{", ".join(sides)} {units}'.rstrip()


def file_of(write: Callable[[bytes], Any], ending: str, title: str) -> bytes:
    """What `write` writes into a file, without warnings of what it left out."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter('ignore')
        path = os.path.join(folder, title + ending)
        write(os.fsencode(path))
        with open(path, 'rb') as file:
            return file.read()


def picture(write: Callable[[bytes], Any]) -> Optional[bytes]:
    """A PNG, or None where none can be drawn: a table is better than an error."""
    try:
        return file_of(write, '.png', 'Quench')
    except Error:
        return None


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        return '<tr>' + ''.join(f'<{tag} style="text-align:left">{escape(cell)}</{tag}>' for cell in cells) + '</tr>'

    top = f'<thead>{line(head, "th")}</thead>' if head else ''
    return f'<table>{top}<tbody>{"".join(line(row, "td") for row in rows)}</tbody></table>'


def card(title: str, facts: Facts, png: Optional[bytes] = None, below: str = '') -> str:
    """HTML of a result. Texts are escaped; `below` is HTML."""
    image = ''
    if png:
        data = base64.b64encode(png).decode()
        image = (f'<img alt="{escape(title)}" width="{SIZE[0] // 2}" height="{SIZE[1] // 2}" style="margin:0 1em 0 0" '
                 f'src="data:image/png;base64,{data}">')
    return (f'<div><strong>{escape(title)}</strong><div style="display:flex;align-items:flex-start;flex-wrap:wrap">{image}'
            f'{table((), facts)}</div>{below}</div>')


class View:
    """The interactive page of a result, one HTML text with its data; made by ``view()``.

    A notebook shows it in a frame; elsewhere :meth:`save` writes it as a file for a browser.

    Attributes
    ----------
    html : str
    height : int
        Of the frame, in pixels.
    """

    def __init__(self, html: str, height: int = 600):
        self.html = html
        self.height = whole(height, 'height', 100)

    def __repr__(self) -> str:
        return f'<quench.View: a page of {len(self.html) / 1e6:.1f} MB; a notebook shows it, save("page.html") writes it>'

    def _repr_html_(self) -> str:
        # Nothing but scripts may run in it, apart from the notebook around.
        return (f'<iframe style="width:100%;height:{self.height}px;border:0" sandbox="allow-scripts allow-downloads" '
                f'srcdoc="{escape(self.html)}"></iframe>')

    def save(self, path: Path) -> None:
        """Writes the page as a file, over an existing one."""
        _core.write_text(written(path), self.html)


def view_of(write: Callable[[bytes], Any], title: str, height: int) -> View:
    whole(height, 'height', 100)
    return View(file_of(write, '.html', title).decode('utf-8'), height)

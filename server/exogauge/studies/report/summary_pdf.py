"""summary.pdf: the one-page report as one sheet of A4, with its fonts embedded.

Letters are those of the font that comes with matplotlib; Japanese and traditional Chinese, which it lacks, are those of
IPAexGothic, which comes with matplotlib-fontja.
Equal pages give equal bytes: no clock is read, so the document's date is that of no day.
"""

from __future__ import annotations

from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import final

import matplotlib
from fpdf import FPDF
from fpdf.enums import MethodReturnValue

from exogauge.studies.report.page_model import UNPRINTED, Block, Box, Drawing, Label, Page, Row, Table
from exogauge.studies.report.page_model import Line as Stroke

SHEET = (210.0, 297.0)  # A4 [mm]
SIDE, TOP, BOTTOM = 12.0, 10.0, 285.0
LETTER = 7.6  # [pt] at scale 1
LEADING = 1.28
GAP = 2.6  # [mm] between rows
GUTTER = 5.0  # between blocks
TERM = 27.0  # width of a fact's name
POINT = 25.4 / 72.0  # [mm]
BASELINE = 0.8  # of a cell as high as its letters, from above
FONT = "DejaVu"
FACES = {"": "DejaVuSans.ttf", "B": "DejaVuSans-Bold.ttf"}
EAST = "IPAexGothic"  # one face, also in bold text
COLOURS = {
    "ink": (0, 0, 0), "muted": (74, 79, 85), "line": (201, 200, 195), "measured": (143, 149, 156),
    "identified": (10, 92, 145), "prior": (176, 71, 27), "doubt": (138, 90, 0),
}  # fmt: skip
NO_DAY = datetime(1970, 1, 1, tzinfo=UTC)


def lay_out(page: Page, scale: float) -> Sheet:
    """One sheet at this scale of letters: whether all found room, `fits`, and the document, `bytes()`, which costs as
    much again."""
    sheet = Sheet(scale)
    sheet.fits = sheet.page(page) <= BOTTOM
    return sheet


@final
class Sheet:
    """Every method draws at a place [mm] and says how far down it came."""

    def __init__(self, scale: float) -> None:
        self.scale, self.fits = scale, False
        self.letter = LETTER * scale
        self.lacking: dict[str, None] = {}
        self.pdf = FPDF(unit="mm", format=SHEET)
        self.pdf.set_creation_date(NO_DAY)
        self.pdf.set_auto_page_break(False)
        self.pdf.set_margin(0.0)
        self.pdf.c_margin = 0.0
        folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
        for style, file in FACES.items():
            self.pdf.add_font(FONT, style, folder / file)
        self.glyphs = {style: set(self.pdf.fonts[FONT.lower() + style].cmap) for style in FACES}  # type: ignore[union-attr]
        self.east: set[int] | None = None
        self.pdf.add_page()

    def bytes(self) -> bytes:
        return bytes(self.pdf.output())

    def put_away(self) -> None:
        """Its fonts' files are open until it is a document, or never will be one."""
        for font in self.pdf.fonts.values():
            font.close()  # type: ignore[union-attr]

    def page(self, page: Page) -> float:
        self.pdf.set_title(self._printed(page.title, ""))
        self.pdf.set_lang("en")
        width = SHEET[0] - 2 * SIDE
        y = self.text(SIDE, TOP, width, page.kicker, colour="muted")
        y = self.text(SIDE, y + 0.4, width, page.title, size=1.75, style="B")
        if page.label:
            y = self._label(y + 0.8, page.label)
        for n, row in enumerate(page.rows):
            y = self._row(row, y + GAP, framed=n == 0)
        self._rule(SIDE, y + GAP - 0.8, width)
        y = self.text(SIDE, y + GAP, width, page.footer, size=0.92, colour="muted")
        if self.lacking:
            y = self.text(SIDE, y + 0.3, width, self._what_lacks(), size=0.92, colour="muted")
        return y

    def _what_lacks(self) -> str:
        some = [f"U+{ord(sign):04X}" for sign in list(self.lacking)[:12]]
        codes = ", ".join(some) + (" …" if len(self.lacking) > len(some) else "")
        return f"{UNPRINTED}: characters that this document’s fonts lack ({codes}); summary.html shows them."

    def _label(self, y: float, text: str) -> float:
        self._font(1.0, "B")
        wide = self.pdf.get_string_width(self._printed(text, "B")) + 4.0
        self.pdf.set_draw_color(*COLOURS["doubt"])
        self.pdf.set_line_width(0.4)
        bottom = self.text(SIDE + 2.0, y + 0.6, wide, text, style="B", colour="doubt")
        self.pdf.rect(SIDE, y, wide, bottom + 0.6 - y)
        return bottom + 0.6

    def _row(self, row: Row, y: float, framed: bool) -> float:
        inset = 2.5 if framed else 0.0
        width = SHEET[0] - 2 * SIDE - 2 * inset - GUTTER * (len(row.blocks) - 1)
        x, bottom = SIDE + inset, y
        for block, share in zip(row.blocks, row.shares, strict=True):
            bottom = max(bottom, self._block(block, x, y + 0.6 * inset, share * width))
            x += share * width + GUTTER
        if framed:
            bottom += 0.6 * inset
            self.pdf.set_draw_color(*COLOURS["identified"])
            self.pdf.set_line_width(0.3)
            self.pdf.rect(SIDE, y, SHEET[0] - 2 * SIDE, bottom - y)
        return bottom

    def _block(self, block: Block, x: float, y: float, width: float) -> float:
        if block.title:
            y = self.text(x, y, width, block.title, size=1.06, style="B") + 0.3
        for sentence in block.sentences:
            y = self.text(x, y, width, sentence) + 0.4
        if block.table is not None:
            y = self._table(block.table, x, y, width)
        if block.drawing is not None:
            y = self._drawing(block.drawing, x, y, width)
        for name, text in block.facts:
            y = max(self.text(x, y, TERM - 2.0, name, style="B"), self.text(x + TERM, y, width - TERM, text)) + 0.25
        for point in block.points:
            self.text(x, y, 3.0, "•")
            y = self.text(x + 3.0, y, width - 3.0, point) + 0.3
        return y

    def _table(self, table: Table, x: float, y: float, width: float) -> float:
        y = self.text(x, y, width, table.caption, colour="muted") + 0.3
        y = self._cells(table, tuple(column.title for column in table.columns), x, y, width, "muted")
        for cells in table.rows:
            y = self._cells(table, cells, x, y, width, "ink")
        return y

    def _cells(self, table: Table, cells: tuple[str, ...], x: float, y: float, width: float, colour: str) -> float:
        bottom, left = y, x
        for column, cell in zip(table.columns, cells, strict=True):
            wide = column.share * width
            place = (left, y + 0.25, wide - 1.5, cell)
            if column.number:
                bottom = max(bottom, self.text(*place, size=self._squeezed(cell, wide - 1.5), colour=colour, align="R"))
            else:
                bottom = max(bottom, self.text(*place, colour=colour))
            left += wide
        self._rule(x, bottom + 0.15, width)
        return bottom + 0.3

    def _squeezed(self, text: str, width: float) -> float:
        """Size of letters at which it stands on one line: a number is not broken."""
        self._font(1.0, "")
        return min(1.0, 0.99 * width / max(self.pdf.get_string_width(self._printed(text, "")), 0.1))

    def _drawing(self, drawing: Drawing, x: float, y: float, width: float) -> float:
        k = min(1.0, width / drawing.width)
        for mark in drawing.marks:
            colour = COLOURS[mark.colour]
            if isinstance(mark, Stroke):
                self.pdf.set_draw_color(*colour)
                self.pdf.set_line_width(mark.width)
                self.pdf.line(x + k * mark.x, y + k * mark.y, x + k * mark.to_x, y + k * mark.to_y)
            elif isinstance(mark, Box):
                self.pdf.set_draw_color(*colour)
                self.pdf.set_fill_color(*colour)
                style = "F" if mark.filled else "D"
                self.pdf.rect(x + k * mark.x, y + k * mark.y, k * mark.width, k * mark.height, style=style)
            else:
                self._letters(mark, x, y, k)
        return y + k * drawing.height

    def _letters(self, mark: Label, x: float, y: float, k: float) -> None:
        self.pdf.set_font(FONT, "", k * mark.size / POINT)
        self.pdf.set_text_color(*COLOURS[mark.colour])
        text = self._printed(mark.text, "")
        width, height = self.pdf.get_string_width(text), k * mark.size
        back = {"start": 0.0, "middle": 0.5, "end": 1.0}[mark.anchor] * width
        self.pdf.set_xy(x + k * mark.x - back, y + k * mark.y - BASELINE * height)
        self.pdf.cell(width, height, text)

    def text(
        self, x: float, y: float, width: float, text: str, *, size: float = 1.0, style: str = "", colour: str = "ink",
        align: str = "L",
    ) -> float:  # fmt: skip
        """Wrapped to the width; words that do not fit are broken."""
        self._font(size, style)
        self.pdf.set_text_color(*COLOURS[colour])
        step = LEADING * size * self.letter * POINT
        printed = self._printed(text, style)
        lines = self.pdf.multi_cell(width, step, printed, dry_run=True, output=MethodReturnValue.LINES, align="L")
        assert isinstance(lines, list)
        for n, line in enumerate(lines):
            self.pdf.set_xy(x, y + n * step)
            self.pdf.cell(width, step, line, align=align)
        return y + len(lines) * step

    def _font(self, size: float, style: str) -> None:
        self.pdf.set_font(FONT, style, size * self.letter)

    def _rule(self, x: float, y: float, width: float) -> None:
        self.pdf.set_draw_color(*COLOURS["line"])
        self.pdf.set_line_width(0.15)
        self.pdf.line(x, y, x + width, y)

    def _printed(self, text: str, style: str) -> str:
        """With a box for every character that the fonts lack."""
        missing = {sign for sign in text if ord(sign) not in self.glyphs[style]}
        lacking = {sign for sign in missing if ord(sign) not in self._east()} if missing else missing
        self.lacking |= dict.fromkeys(sign for sign in text if sign in lacking)
        return "".join(UNPRINTED if sign in lacking else sign for sign in text)

    def _east(self) -> set[int]:
        """What the second font has. It is large, and read only where the first one lacks something."""
        if self.east is None:
            self.pdf.add_font(EAST, "", _file_of_east())
            self.pdf.set_fallback_fonts([EAST], exact_match=False)
            self.east = set(self.pdf.fonts[EAST.lower()].cmap)  # type: ignore[union-attr]
        return self.east


def _file_of_east() -> Path:
    """The package is not imported: it would change matplotlib's settings."""
    found = find_spec("matplotlib_fontja")
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent / "fonts" / "ipaexg.ttf"

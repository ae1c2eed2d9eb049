"""Pages of a PDF as pixels, and squares of 50 mm in them."""

import io
import subprocess

import numpy
from PIL import Image

DPI = 300
MM = 25.4 / DPI


def page(pdf, number, dpi=DPI):
    """Darkness of a page's pixels, from 0 to 1, as poppler draws it."""
    command = ["pdftoppm", "-r", str(dpi), "-f", str(number), "-l", str(number), "-gray", "-png", str(pdf)]
    shown = subprocess.run(command, timeout=30, check=True, capture_output=True)
    return 1 - numpy.asarray(Image.open(io.BytesIO(shown.stdout)).convert("L"), float) / 255


def runs(is_dark, least):
    """Row, first and last column + 1 of every run of dark pixels that is at least so long."""
    padded = numpy.pad(is_dark.astype(numpy.int8), ((0, 0), (1, 1)))
    step = numpy.diff(padded, axis=1)
    starts, ends = numpy.argwhere(step == 1), numpy.argwhere(step == -1)
    long = ends[:, 1] - starts[:, 1] >= least
    return numpy.column_stack([starts[long], ends[long][:, 1]])


def strokes(is_dark, mm):
    """Straight level lines of about that length: middle of their rows, and both ends, in pixels."""
    wanted = mm / MM
    found = []
    for row, first, last in runs(is_dark, wanted * 0.96):
        if last - first > wanted * 1.06:
            continue
        same = next((s for s in found if s["last_row"] >= row - 1 and abs(s["first"] - first) <= 3 and abs(s["last"] - last) <= 3), None)
        if same is None:
            same = {"rows": [], "first": first, "last": last}
            found.append(same)
        same["rows"].append(row)
        same["last_row"] = row
    return [(numpy.mean(s["rows"]) + 0.5, s["first"], s["last"], len(s["rows"])) for s in found]


def squares(darkness, mm=50):
    """Width and height, between the middles of the strokes, of every square of about that size."""
    is_dark = darkness > 0.25
    level, upright = strokes(is_dark, mm), strokes(is_dark.T, mm)
    found = []
    for top, left, right, _ in level:
        for bottom, left_too, right_too, _ in level:
            if not 0.94 * mm < (bottom - top) * MM < 1.06 * mm or abs(left - left_too) > 3 or abs(right - right_too) > 3:
                continue
            columns = sorted(x for x, y, _, _ in upright if abs(y - top) < 12 and left - 12 < x < right + 12)
            if len(columns) >= 2:
                found.append(((columns[-1] - columns[0]) * MM, (bottom - top) * MM))
    return found

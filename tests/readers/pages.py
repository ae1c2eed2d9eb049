"""PDF: boxes by two readers, layers, and the control square in pixels."""

import re
import subprocess

import pypdf

import raster
from meshes import model_of

MM = 72 / 25.4
# Width and height in millimetres.
PAPERS = {"A4": (210, 297), "A3": (297, 420), "Letter": (215.9, 279.4), "Legal": (215.9, 355.6), "Tabloid": (279.4, 431.8)}
# Points: four decimals and their rounding.
POINT = 0.01


def is_paper(width, height, sheet):
    sizes = [*PAPERS.values(), *((h, w) for w, h in PAPERS.values())]
    known = [(w * MM, h * MM) for w, h in sizes] + [(sheet[0] * MM, sheet[1] * MM)]
    return any(abs(width - w) < POINT and abs(height - h) < POINT for w, h in known)


def check_pdf(path, hold):
    model = model_of(path)
    reader = pypdf.PdfReader(path, strict=True)
    boxes = [(float(page.mediabox.width), float(page.mediabox.height)) for page in reader.pages]
    hold(len(boxes) > 0, f"pypdf reads it strictly: {len(boxes)} pages")
    is_roll = "roll" in path.name or "sheet" in path.name
    if not is_roll:
        hold(all(is_paper(w, h, model["sheet"]["size"]) for w, h in boxes), "all pages are sheets of paper that one can buy")
    hold(all(max(box) <= 14400 for box in boxes), "no page is larger than readers show")
    hold(all(page.get("/UserUnit", 1) == 1 and page.rotation == 0 for page in reader.pages), "pages have no unit and no rotation of their own")
    told = subprocess.run(["pdfinfo", "-f", "1", "-l", str(len(boxes)), str(path)], timeout=30, check=True, capture_output=True, text=True)
    sizes = re.findall(r"Page\s+\d+ size:\s+([\d.]+) x ([\d.]+) pts", told.stdout)
    # pdfinfo prints six digits.
    agree = all(abs(w - float(a)) < 0.01 and abs(h - float(b)) < 0.01 for (w, h), (a, b) in zip(boxes, sizes))
    hold(len(sizes) == len(boxes) and agree, "pdfinfo tells the same sizes")
    hold(not told.stderr.strip(), "poppler has nothing to complain of")
    catalog = reader.trailer["/Root"]
    hold(catalog.get("/ViewerPreferences", {}).get("/PrintScaling") == "/None", "viewers are told not to scale")
    names = {str(group.get_object()["/Name"]).upper() for group in catalog.get("/OCProperties", {}).get("/OCGs", [])}
    hold("CUT" in names, f"kinds of lines are layers: {', '.join(sorted(names))}")
    fonts = subprocess.run(["pdffonts", str(path)], timeout=30, check=True, capture_output=True, text=True)
    hold(not fonts.stderr.strip(), "its fonts are read without complaint")
    check_squares(path, reader, hold)


def check_squares(path, reader, hold):
    """The control square on the first page, and on the first one after it that has one."""
    measured = []
    for number in range(1, min(len(reader.pages), 3) + 1):
        found = raster.squares(raster.page(path, number))
        off = [max(abs(w - 50), abs(h - 50)) for w, h in found]
        # A square of two inches is 50.8 mm wide: another one.
        if off:
            measured.append((number, min(off)))
    hold(bool(measured) and measured[0][0] == 1, "the first page has a control square")
    worst = max(off for _, off in measured)
    hold(worst <= 0.2, f"control squares on pages {', '.join(str(n) for n, _ in measured)} measure 50 mm at 300 dpi, to 0.2 mm ({worst:.3f} off)")

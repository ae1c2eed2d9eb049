"""Drawings: SVG and DXF against the lines of the sheet in `model.json`."""

import re
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import ezdxf
import numpy

import raster
from meshes import model_of

# Millimetres. Formats write four decimals; a hundredth is what the workshop is promised.
OUTLINE = 0.01
NOTCH = 0.1
SEAM = 0.1
SVG = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


def distances(points, line):
    """From each point to a polyline."""
    points, line = numpy.asarray(points, float), numpy.asarray(line, float)
    a, d = line[:-1], numpy.diff(line, axis=0)
    squared = numpy.maximum((d**2).sum(axis=1), 1e-300)
    nearest = numpy.full(len(points), numpy.inf)
    for start, step, size in zip(a, d, squared):
        t = numpy.clip(((points - start) @ step) / size, 0, 1)
        nearest = numpy.minimum(nearest, numpy.linalg.norm(points - start - t[:, None] * step, axis=1))
    return nearest


def closed(points):
    return [*points, points[0]]


def deviation(a, b):
    """Largest distance between two polylines, either way."""
    return max(distances(a, b).max(), distances(b, a).max())


def length(points):
    return float(numpy.linalg.norm(numpy.diff(numpy.asarray(points), axis=0), axis=1).sum())


def full(points, is_closed):
    return closed(points) if is_closed and len(points) > 1 else points


def box(points):
    points = numpy.asarray(points)
    return numpy.concatenate([points.min(axis=0), points.max(axis=0)])


def worst_match(wanted, found):
    """For the lines wanted the largest deviation of the best line found; each is used once."""
    left, worst = list(found), 0.0
    boxes = [box(line) for line in left]
    for line in wanted:
        near = sorted(range(len(left)), key=lambda i: numpy.abs(boxes[i] - box(line)).max())[:8]
        if not near:
            return numpy.inf
        best = min(near, key=lambda i: deviation(line, left[i]))
        worst = max(worst, deviation(line, left[best]))
        del left[best], boxes[best]
    return worst


def wanted_lines(model, layer):
    lines = [line for line in model["sheet"]["lines"] if line["layer"] == layer]
    return [full(line["points"], line["closed"]) for line in lines]


# SVG


def svg_paths(root):
    """Layer, id, whether closed, and points of every path."""
    for group in root.iter(f"{SVG}g"):
        for path in group.iter(f"{SVG}path"):
            text = path.get("d")
            numbers = [float(x) for x in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]
            yield group.get(LABEL), path.get("id"), text.rstrip().endswith("Z"), numpy.reshape(numbers, (-1, 2)), text


def check_svg(path, hold):
    root = ElementTree.parse(path).getroot()
    hold(root.tag == f"{SVG}svg", "an XML parser reads an svg")
    width, height = root.get("width"), root.get("height")
    hold(width.endswith("mm") and height.endswith("mm"), "the size is in millimetres")
    hold(root.get("viewBox") == f"0 0 {width[:-2]} {height[:-2]}", "one unit is one millimetre, digit for digit")
    elements = list(root.iter())
    hold(all(e.get("transform") is None for e in elements), "there is no transform")
    ids = [e.get("id") for e in elements if e.get("id")]
    hold(len(ids) == len(set(ids)), "no id occurs twice")
    text = path.read_text(encoding="utf-8")
    hold(not re.search(r"\bNaN\b|\binf\b", text, re.I), "all numbers are finite")
    model = model_of(path)
    if model is None:
        return
    paths = list(svg_paths(root))
    top = float(height[:-2])
    hold(abs(top - model["sheet"]["size"][1]) < 1e-4, "the sheet is as high as it should be")
    for layer in sorted({line["layer"] for line in model["sheet"]["lines"]}):
        # Curves have control points off the line: those layers are measured in the browser.
        if any("C" in d for label, _, _, _, d in paths if label == layer):
            continue
        found = [full([(x, top - y) for x, y in p], z) for label, _, z, p, _ in paths if label == layer]
        worst = worst_match(wanted_lines(model, layer), found)
        hold(worst <= OUTLINE, f"lines of {layer} lie where the sheet has them, to {OUTLINE} mm ({worst:.5f})")


# DXF


def entities(document):
    """Layer, whether closed, and points of every line, blocks inserted where they belong."""

    def walk(entity):
        kind = entity.dxftype()
        if kind == "INSERT":
            for inner in entity.virtual_entities():
                yield from walk(inner)
        elif kind == "POLYLINE":
            yield entity.dxf.layer, entity.is_closed, [(p.x, p.y) for p in entity.points()]
        elif kind == "LINE":
            yield entity.dxf.layer, False, [(entity.dxf.start.x, entity.dxf.start.y), (entity.dxf.end.x, entity.dxf.end.y)]

    for entity in document.modelspace():
        yield from walk(entity)


def read_dxf(path, hold):
    data = path.read_bytes()
    hold(max(data) < 0x80, "all bytes are ASCII")
    hold(data.endswith(b"EOF\r\n") and data.count(b"\n") == data.count(b"\r\n"), "lines end as DXF has them, and the last is EOF")
    document = ezdxf.readfile(path)
    audit = document.audit()
    hold(not audit.errors and not audit.fixes, f"ezdxf reads it strictly, {len(audit.errors)} errors, {len(audit.fixes)} fixes")
    hold(document.dxfversion == "AC1009", "it is R12")
    return document


def check_dxf(path, hold):
    document = read_dxf(path, hold)
    model = model_of(path)
    found = list(entities(document))
    hold(numpy.isfinite(numpy.concatenate([p for _, _, p in found])).all(), "all coordinates are finite")
    for layer, is_closed, points in found:
        gaps = numpy.linalg.norm(numpy.diff(full(points, is_closed), axis=0), axis=1)
        if len(points) < 2 or gaps.min() <= 0:
            raise AssertionError(f"a line of {layer} has a side without length")
    for layer in sorted({line["layer"] for line in model["sheet"]["lines"]}):
        tolerance = NOTCH if layer == "NOTCH" else OUTLINE
        own = [full(points, is_closed) for name, is_closed, points in found if name == layer]
        worst = worst_match(wanted_lines(model, layer), own)
        hold(worst <= tolerance, f"lines of {layer} measure what the sheet says, to {tolerance} mm ({worst:.5f})")
    wanted = sum(line["closed"] for line in model["sheet"]["lines"] if line["layer"] == "CUT")
    hold(sum(is_closed for layer, is_closed, _ in found if layer == "CUT") == wanted, "closed outlines are flagged as closed")
    check_seams(model, found, hold)
    check_librecad(path, hold)


def outline_run(outline, points):
    """The part of a closed polyline along a seam, from the seam's first point to its last; none if the seam is not on it."""
    ring = numpy.asarray(outline)[:-1]
    near = [numpy.flatnonzero(numpy.linalg.norm(ring - p, axis=1) <= OUTLINE) for p in (points[0], points[-1])]
    best, best_deviation = None, OUTLINE
    # Both sides of a slit have points at the same places.
    for first in near[0]:
        for last in near[1]:
            count = (last - first) % len(ring) or len(ring)
            run = ring[(first + numpy.arange(count + 1)) % len(ring)]
            off = deviation(points, run)
            if off <= best_deviation:
                best, best_deviation = run, off
    return best


def pairs(seams):
    """The two sides of each seam."""
    by_number = {}
    for seam in seams:
        by_number.setdefault(seam["number"], []).append(seam)
    return by_number


def check_seams(model, found, hold):
    """Lengths and notches of partners, measured on the lines of the file."""
    layers = {layer for layer, _, _ in found}
    layer = "SEW" if "SEW" in layers else "CUT"
    outlines = [full(points, True) for name, is_closed, points in found if name == layer and is_closed]
    notches = [points for name, _, points in found if name == "NOTCH"]
    sides = pairs(model["sheet"]["seams"])
    hold(all(len(side) == 2 for side in sides.values()), "every seam has two sides")
    worst = 0.0
    runs = {}
    for number, both in sides.items():
        measured = []
        for i, seam in enumerate(both):
            run = next((r for r in (outline_run(o, seam["points"]) for o in outlines) if r is not None), None)
            if run is None:
                # A fold edge, or an outline that is drawn as several lines: nothing to measure.
                continue
            runs[number, i] = run
            measured.append(length(run))
        if len(measured) == 2:
            worst = max(worst, abs(measured[0] - measured[1]))
    hold(len(runs) > 0, f"seams are found on the outlines of {layer}")
    if model["has_true_rims"]:
        hold(worst <= SEAM, f"partner seams are equally long, to {SEAM} mm ({worst:.5f})")
        check_notches(runs, sides, notches, hold)


def along(points, p):
    """Distance to a polyline, and the length of it up to there."""
    points = numpy.asarray(points)
    a, d = points[:-1], numpy.diff(points, axis=0)
    sizes = numpy.linalg.norm(d, axis=1)
    t = numpy.clip(((p - a) * d).sum(axis=1) / numpy.maximum(sizes**2, 1e-300), 0, 1)
    gaps = numpy.linalg.norm(p - a - t[:, None] * d, axis=1)
    i = int(gaps.argmin())
    return float(gaps[i]), float(sizes[:i].sum() + t[i] * sizes[i])


def check_notches(runs, sides, notches, hold):
    if not notches:
        return
    places = {key: [] for key in runs}
    for notch in notches:
        middle = numpy.mean(numpy.asarray(notch), axis=0)
        key = min(runs, key=lambda k: along(runs[k], middle)[0])
        places[key].append(along(runs[key], middle)[1])
    worst = 0.0
    for number in sides:
        if (number, 0) not in runs or (number, 1) not in runs:
            continue
        total = length(runs[number, 1])
        mine, theirs = places[number, 0], [total - x for x in places[number, 1]]
        if len(mine) != len(theirs):
            raise AssertionError(f"seam {number} has {len(mine)} notches on one side and {len(theirs)} on the other")
        if sides[number][0]["closed"]:
            # Both sides begin at one point of the surface, wherever their lines are begun.
            begins = [along(runs[number, k], numpy.asarray(sides[number][k]["start"]))[1] for k in (0, 1)]
            mine = [(x - begins[0]) % total for x in mine]
            theirs = [(x + begins[1]) % total for x in theirs]
            gaps = [min(min(abs(a - b), total - abs(a - b)) for b in theirs) for a in mine]
        else:
            gaps = [abs(a - b) for a, b in zip(sorted(mine), sorted(theirs))]
        worst = max([worst, *gaps])
    hold(worst <= NOTCH, f"notches of partners meet, to {NOTCH} mm ({worst:.5f})")


def check_librecad(path, hold):
    """LibreCAD prints the file on A4, from the sheet's low corner, where the control square is; that is measured."""
    with tempfile.TemporaryDirectory() as folder:
        pdf = Path(folder) / f"{path.stem}.pdf"
        command = ["librecad", "dxf2pdf", "-t", folder, str(path.resolve())]
        # It keeps settings, and asks for them at its first start.
        environment = {"QT_QPA_PLATFORM": "offscreen", "HOME": folder, "XDG_RUNTIME_DIR": folder, "PATH": "/usr/bin:/bin"}
        subprocess.run(command, env=environment, timeout=30, check=True, capture_output=True)
        hold(pdf.exists(), "LibreCAD prints it")
        squares = raster.squares(raster.page(pdf, 1))
    hold(bool(squares), "LibreCAD's page shows the control square")
    # A stroke has a width of its own there.
    best = min(max(abs(w - 50), abs(h - 50)) for w, h in squares)
    hold(best <= 0.3, f"it measures 50 mm in LibreCAD ({best:.3f} off)")


def check_astm(path, hold):
    """The variant of the clothing trade: layers are numbers, pieces are blocks, and nothing else is there."""
    document = read_dxf(path, hold)
    hold(b"\r\nTABLES\r\n" not in path.read_bytes(), "there are no tables")
    modelspace = list(document.modelspace())
    hold({e.dxftype() for e in modelspace} <= {"TEXT", "INSERT"}, "outside of blocks there are texts and insertions only")
    texts = [e.dxf.text for e in modelspace if e.dxftype() == "TEXT"]
    for key in ("Style Name:", "Creation Date:", "Author:", "Sample Size:", "Units: METRIC"):
        hold(any(text.startswith(key) for text in texts), f"the style says {key}")
    inserted = [e.dxf.name for e in modelspace if e.dxftype() == "INSERT"]
    pieces = len({line["piece"] for line in model_of(path)["sheet"]["lines"] if line["layer"] == "CUT"})
    hold(len(inserted) == len(set(inserted)) == pieces, "every piece is a block, inserted once")
    for name in inserted:
        block = list(document.blocks[name])
        outlines = [e for e in block if e.dxftype() == "POLYLINE" and e.dxf.layer == "1"]
        lines = [e for e in block if e.dxftype() == "POLYLINE" and e.dxf.layer in {"1", "8", "11", "14"}]
        points = [e for e in block if e.dxftype() == "POINT" and e.dxf.layer in {"2", "3"}]
        # A closed line of n points has n vertices; an open one as well.
        vertices = sum(len(e) for e in lines)
        if len(outlines) != 1 or not outlines[0].is_closed:
            raise AssertionError(f"block {name} has {len(outlines)} outlines")
        if signed_area([(p.x, p.y) for p in outlines[0].points()]) <= 0:
            raise AssertionError(f"the outline of block {name} runs clockwise")
        if len(points) != vertices:
            raise AssertionError(f"block {name} has {len(points)} turn and curve points for {vertices} vertices")
        if not any(e.dxftype() == "LINE" and e.dxf.layer == "7" for e in block):
            raise AssertionError(f"block {name} has no grain line")
        if not any(e.dxftype() == "TEXT" and e.dxf.text.startswith("Piece Name:") for e in block):
            raise AssertionError(f"block {name} does not say its name")
    hold(True, "each block has one closed outline, its turn and curve points, a grain line and a name")


def signed_area(points):
    p = numpy.asarray(points)
    q = numpy.roll(p, -1, axis=0)
    return 0.5 * float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())

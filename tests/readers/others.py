"""Pictures, archives and JSON."""

import json
import zipfile

import numpy
from PIL import Image


def check_png(path, hold):
    with Image.open(path) as image:
        image.verify()
    with Image.open(path) as image:
        hold(image.mode == "RGB" and image.size == (512, 512), "Pillow reads 512 × 512 pixels of three channels")
        pixels = numpy.asarray(image)
    colours = {tuple(c) for c in pixels.reshape(-1, 3)}
    hold((0x6B, 0x9A, 0xD8) in colours, "the first piece has its colour")
    hold(len(colours) > 2, "seams and pieces differ")


def check_zip(path, hold):
    with zipfile.ZipFile(path) as archive:
        hold(archive.testzip() is None, "Python's zipfile unpacks everything, sums agree")
        names = archive.namelist()
        hold("pieces/Bär.txt" in names, "names are UTF-8")
        safe = all(not n.startswith("/") and ".." not in n.split("/") and "\\" not in n for n in names)
        hold(safe, "no name leaves the folder")
        hold(all(i.date_time == (1980, 1, 1, 0, 0, 0) for i in archive.infolist()), "no file has a date")
        own = [n for n in names if "/" not in n]
        hold(all(archive.read(n) == path.with_name(n).read_bytes() for n in own), "files are those beside the archive")


def check_json(path, hold):
    def refuse(word):
        raise AssertionError(f"{word} is no JSON")

    value = json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
    hold(isinstance(value, dict) and len(value) > 0, "Python reads an object without NaN")

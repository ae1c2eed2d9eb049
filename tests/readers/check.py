"""Looks at exported files with readers that are not ours: `cargo xtask test --readers` starts it.

    python check.py FOLDER

`files.json` lists what must be there; a file that is missing, and one that is not on the list, is a failure. What is looked at
follows from a file's name. Each check is one sentence; the first that does not hold ends the file. A reader that hangs is stopped.
"""

import fnmatch
import json
import multiprocessing
import sys
import time
import traceback
from pathlib import Path

import drawings
import meshes
import others
import pages

# Seconds for all checks of one file. The slowest takes a few.
LIMIT = 60

# The first pattern that fits decides.
CHECKS = [
    ("input.obj", meshes.check_input),
    ("uv.obj", meshes.check_uv_obj),
    ("flat.obj", meshes.check_flat_obj),
    ("cut.obj", meshes.check_cut_obj),
    ("*.obj", meshes.check_any_obj),
    ("*.ply", meshes.check_ply),
    ("*.glb", meshes.check_glb),
    ("*.png", others.check_png),
    ("*.zip", others.check_zip),
    ("*.json", others.check_json),
    ("*.svg", drawings.check_svg),
    ("*astm*.dxf", drawings.check_astm),
    ("*.dxf", drawings.check_dxf),
    ("*.pdf", pages.check_pdf),
]


def check_of(name):
    return next((check for pattern, check in CHECKS if fnmatch.fnmatch(name, pattern)), None)


def look(check, path, results):
    """Runs in a process of its own."""
    said = []

    def hold(is_true, sentence):
        said.append(sentence)
        if not is_true:
            raise AssertionError(sentence)

    try:
        check(path, hold)
        if not said:
            raise AssertionError("nothing was checked")
        results.put((True, said))
    except AssertionError as error:
        results.put((False, [f"NOT TRUE: {error}"]))
    except Exception:
        results.put((False, [traceback.format_exc()]))


def run(path):
    """Whether all checks of a file hold, and what they say."""
    check = check_of(path.name)
    if check is None:
        return False, [f"no check in check.py fits {path.name}"]
    if not path.is_file():
        return False, ["the file is missing"]
    results = multiprocessing.Queue()
    process = multiprocessing.Process(target=look, args=(check, path, results))
    process.start()
    try:
        outcome = results.get(timeout=LIMIT)
    except Exception:
        outcome = False, [f"no answer within {LIMIT} s"]
    process.join(timeout=1)
    if process.is_alive():
        process.kill()
    return outcome


def main():
    folder = Path(sys.argv[1])
    listed = json.loads((Path(__file__).parent / "files.json").read_text())
    wanted = {f"{name}/{file}" for name, files in listed.items() for file in files}
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    failures = [f"{name}: not in files.json, so nothing would look at it" for name in sorted(found - wanted)]
    for name in sorted(wanted):
        start = time.monotonic()
        is_fine, said = run(folder / name)
        print(f"{name}  {time.monotonic() - start:.1f} s")
        for sentence in said:
            print(f"  {'ok' if is_fine else 'FAILED'}  {sentence}")
        if not is_fine:
            failures.append(f"{name}: {said[-1].strip().splitlines()[-1]}")
    for failure in failures:
        print(f"FAILED  {failure}")
    print(f"{len(wanted)} files, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

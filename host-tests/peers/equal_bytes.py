#!/usr/bin/env python3
"""The share of equal 8-bit values on every volume of a folder, rendered with the scene that the program chooses for it.

    python equal_bytes.py PATH/TO/slicecast FOLDER [OPTIONS OF compare...]        (standard library only)

A volume is what `inspect` reads: a file, or a folder of DICOM or TIFF slices, or a header with its data beside it. Each is
compared with the f64 model at `compact` and `wide`; a line per volume says the scene, the equal shares on the base plane and
the largest difference in steps of 1/255. Exits 1 if a share is below the aim: 99.3 % in `compact`, 99.9 % in `wide`.
"""
import json, pathlib, re, subprocess, sys, tempfile

AIMS = {"compact": 99.3, "wide": 99.9}
# Data that a header beside it names.
DATA = {".raw", ".zraw", ".md", ".png", ".tsv", ".toml", ".rs", ".txt"}


def volumes(folder):
    """Every volume below a folder; a folder that is one is not looked into."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith(".") or path.name in ("LICENSES", "SHA256SUMS"):
            continue
        if path.is_dir():
            slices = [file.stem for file in path.iterdir() if file.suffix in (".dcm", ".tif") and file.name[0] != "."]
            numbered = len({re.sub(r"\d+", "", name) for name in slices}) == 1 and len(slices) > 1
            if numbered or any(path.glob("*.dcm")) or (path / "DICOMDIR").is_file():
                yield path
            else:
                yield from volumes(path)
        elif path.suffix not in DATA:
            yield path


def compared(program, path, precision, options):
    """The figures of a comparison, and the scene; the program's last line if there are none."""
    with tempfile.TemporaryDirectory() as folder:
        figures = pathlib.Path(folder) / "figures.json"
        command = [program, "compare", str(path), "--precision", precision, "--json", str(figures), *options]
        done = subprocess.run(command, capture_output=True, text=True)
        said = done.stdout + done.stderr
        scene = re.search(r"^scene: ([\w-]+)", said, re.M)
        if done.returncode != 0:
            return None, said.strip().splitlines()[-1]
        return json.loads(figures.read_text()), scene[1] if scene else "?"


def main():
    program, folder, *options = sys.argv[1:]
    folder, short = pathlib.Path(folder), 0
    print("| volume | scene | `compact` | step | `wide` | step |\n|---|---|---|---|---|---|", flush=True)
    for path in volumes(folder):
        cells, scene, refused = [], "", None
        for precision, aim in AIMS.items():
            figures, scene = compared(program, path, precision, options)
            if figures is None:
                refused = scene
                break
            image = figures["image"]
            low = image["values"] > 0 and image["equal_percent"] < aim
            short += low
            mark = "**" if low else ""
            cells += [f"{mark}{image['equal_percent']:.2f} %{mark}", f"{image['max_lsb8']:.3f}"]
        name = path.relative_to(folder)
        print(f"| {name} | {refused or scene} | {' | '.join(cells or ['-'] * 4)} |", flush=True)
    print(f"{short} shares below the aim of {', '.join(f'{aim} % in {name}' for name, aim in AIMS.items())}")
    return short > 0


if __name__ == "__main__":
    sys.exit(main())

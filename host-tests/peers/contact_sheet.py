#!/usr/bin/env python3
"""A sheet of the default pictures of every volume of a folder, by two versions of the program side by side.

    python contact_sheet.py BEFORE AFTER FOLDER SHEET.png        (with pillow installed)

BEFORE and AFTER are two `slicecast` programs. Each renders every volume (`equal_bytes.py` says what one is) without any
option. A cell has both pictures at one scale, AFTER on the right; a refusal is shown as its message. Prints a line per volume:
the sizes of both pictures, and their mean difference in steps of 1/255 where the sizes are equal.
"""
import pathlib, subprocess, sys, tempfile, textwrap

from PIL import Image, ImageChops, ImageDraw, ImageStat

from equal_bytes import volumes

SIDE, ACROSS, LINE = 220, 4, 14


def rendered(program, path):
    """The picture, or what the program said when it made none."""
    with tempfile.TemporaryDirectory() as folder:
        return rendered_in(folder, program, path)


def rendered_in(folder, program, path):
    out = pathlib.Path(folder) / "picture.png"
    done = subprocess.run([program, "render", str(path), "-o", str(out)], capture_output=True, text=True)
    if done.returncode != 0 or not out.is_file():
        return None, (done.stderr.strip() or "no picture").splitlines()[-1].replace(str(path.parent) + "/", "")
    with Image.open(out) as picture:
        return picture.convert("RGB"), ""


def cell(name, pair):
    """Both pictures under the volume's name, scaled alike."""
    sheet = Image.new("RGB", (2 * SIDE + 6, SIDE + LINE + 4), (40, 40, 48))
    draw = ImageDraw.Draw(sheet)
    draw.text((2, 1), name, fill=(255, 255, 255))
    for place, (picture, said) in enumerate(pair):
        left = 2 + place * (SIDE + 2)
        if picture is None:
            draw.multiline_text((left + 4, LINE + 8), textwrap.fill(said, 34), fill=(255, 160, 120))
            continue
        shrunk = picture.copy()
        # Small pictures are enlarged as well: both show the volume, not their size.
        scale = min(SIDE / picture.width, SIDE / picture.height)
        shrunk = shrunk.resize([max(1, round(side * scale)) for side in picture.size], Image.Resampling.BILINEAR)
        sheet.paste(shrunk, (left, LINE + 2))
    return sheet


def main():
    before, after, folder, out = sys.argv[1:]
    folder, cells = pathlib.Path(folder), []
    for path in volumes(folder):
        name = str(path.relative_to(folder))
        pair = [rendered(program, path) for program in (before, after)]
        sizes = ["x".join(map(str, picture.size)) if picture else "refused" for picture, _ in pair]
        line = f"{name}: {sizes[0]}, {sizes[1]}"
        if sizes[0] == sizes[1] != "refused":
            difference = ImageStat.Stat(ImageChops.difference(pair[0][0], pair[1][0]))
            line += f", mean difference {sum(difference.mean) / 3:.3f}"
        print(line, flush=True)
        cells.append(cell(name, pair))
    rows = -(-len(cells) // ACROSS)
    width, height = cells[0].size
    sheet = Image.new("RGB", (ACROSS * width, rows * height))
    for index, picture in enumerate(cells):
        sheet.paste(picture, (index % ACROSS * width, index // ACROSS * height))
    sheet.save(out)


if __name__ == "__main__":
    main()

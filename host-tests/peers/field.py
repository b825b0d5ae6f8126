"""Checks the program on files of the kinds that people report to viewers as read wrongly: what the manifest says is right.

    python field.py PATH/TO/slicecast FOLDER        (standard library only)

FOLDER/MANIFEST.tsv names a file or folder a line (columns path, class, expected, kin). Each has its checks below, made with
`inspect`, `render` and `turntable`; a line without a check and a check without a line are faults. Whatever loads is also
rendered as it is, and must say the same notes and warnings as `inspect` does. Prints a line per path; exits 1 on any fault.
"""
import csv, json, math, pathlib, re, struct, subprocess, sys, tempfile, zlib

REPOSITORY = pathlib.Path(__file__).parents[2]


class Picture:
    """A PNG of 8 bits and three channels."""

    def __init__(self, data):
        at, packed = 8, b""
        while at < len(data):
            length, kind = struct.unpack(">I4s", data[at : at + 8])
            body = data[at + 8 : at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, depth, colour = struct.unpack(">2I2B", body[:10])
                assert (depth, colour) == (8, 2), "expected 8 bits and three channels"
            packed += body if kind == b"IDAT" else b""
            at += 12 + length
        data, row = zlib.decompress(packed), 3 * self.width
        self.rows, above = [], bytearray(row)
        for start in range(0, len(data), row + 1):
            line = bytearray(data[start + 1 : start + 1 + row])
            self.unfilter(data[start], line, above)
            self.rows.append(line)
            above = line

    @staticmethod
    def unfilter(kind, line, above):
        for i in range(len(line)):
            left, corner = (line[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            up = above[i]
            if kind == 4:
                nearest = left + up - corner
                line[i] = (line[i] + min((left, up, corner), key=lambda near: abs(nearest - near))) & 255
            else:
                line[i] = (line[i] + (0, left, up, (left + up) // 2)[kind]) & 255

    def lit(self):
        """For each row which pixels are brighter than 8 of 255."""
        return [[max(row[i : i + 3]) > 8 for i in range(0, len(row), 3)] for row in self.rows]

    def share(self):
        return 100 * sum(map(sum, self.lit())) / (self.width * self.height)

    def extent(self):
        """How many columns and rows from the first to the last that has a lit pixel."""
        span = lambda found: max(found) - min(found) + 1 if found else 0
        lit = self.lit()
        columns = [x for x in range(self.width) if any(row[x] for row in lit)]
        return span(columns), span([y for y, row in enumerate(lit) if any(row)])

    def centre(self):
        row = self.rows[self.height // 2]
        return max(row[3 * (self.width // 2) :][:3])


class Program:
    def __init__(self, binary, folder):
        self.binary, self.folder = pathlib.Path(binary).resolve(), pathlib.Path(folder)

    def run(self, command, path, *options):
        words = [self.binary, command, path, *map(str, options)]
        return subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=300)

    def inspect(self, path, *options):
        done = self.run("inspect", path, "--json", *options)
        return json.loads(done.stdout) if done.returncode == 0 else {"refused": done.stderr.strip(), "code": done.returncode}

    def render(self, path, *options):
        """The picture's bytes, what was said, and the legend if there is one."""
        with tempfile.TemporaryDirectory() as out:
            out = pathlib.Path(out)
            done = self.run("render", path, "-o", out / "a.png", *options)
            assert done.returncode == 0, f"render {' '.join(map(str, options))}: code {done.returncode}: {done.stderr.strip()}"
            legend = out / "a.legend.json"
            return (out / "a.png").read_bytes(), done.stderr.splitlines(), json.loads(legend.read_text()) if legend.exists() else None

    def turn(self, path, frames, *options):
        with tempfile.TemporaryDirectory() as out:
            done = self.run("turntable", path, "-o", f"{out}/a.png", "--numbered", "--frames", frames, *options)
            assert done.returncode == 0, f"turntable: code {done.returncode}: {done.stderr.strip()}"
            return [Picture(file.read_bytes()) for file in sorted(pathlib.Path(out).iterdir())]


def near(found, wanted, tolerance):
    return len(found) == len(wanted) and all(abs(a - b) <= tolerance for a, b in zip(found, wanted))


def facts(options=(), dims=(20, 22, 16), spacing=(1.4, 1.4, 1.4), within=1e-4, notes=(), without=(), **equal):
    """`inspect --json`: sizes and other values exactly, spacing within a part of itself, words in the notes or absent."""

    def check(program, path):
        found = program.inspect(path, *options)
        if "refused" in found:
            yield f"refused with code {found['code']}: {found['refused']}"
            return
        if found["dims"] != list(dims):
            yield f"dims {found['dims']}, expected {dims}"
        scaled = [a / b for a, b in zip(found["spacing"], spacing)]
        if not near(scaled, [1] * 3, within):
            yield f"spacing {found['spacing']}, expected {spacing}"
        for key, value in equal.items():
            same = near(found[key], value, 1e-6) if key == "range" else found[key] == value
            if not same:
                yield f"{key} {found[key]}, expected {value}"
        said = "\n".join(found["notes"])
        yield from (f"no note says `{word}`: {said}" for word in notes if word not in said)
        yield from (f"a note says `{word}`" for word in without if word in said)

    check.loads = not options
    return check


def ratio(wanted):
    """Spacing in a ratio, whatever the unit."""

    def check(program, path):
        first, *others = program.inspect(path)["spacing"]
        if not near([side / first for side in others], [side / wanted[0] for side in wanted[1:]], 1e-6):
            yield f"spacing {first, *others}, expected the ratio {wanted}"

    return check


def refused(*words):
    """Exit code 2, no picture, and one line that names the path and says these words."""

    def check(program, path):
        with tempfile.TemporaryDirectory() as out:
            done = program.run("render", path, "-o", f"{out}/a.png")
            text = done.stderr.strip()
            if done.returncode != 2 or len(text.splitlines()) != 1 or any(pathlib.Path(out).iterdir()):
                yield f"code {done.returncode} and {len(text.splitlines())} lines, expected 2 and one line, no picture"
            yield from (f"the refusal does not say `{word}`: {text}" for word in (path, *words) if word not in text)

    return check


def lit(percent, *options):
    """Share of the pixels of a square picture, for which the manifest states it, to half a percent of the picture."""

    def check(program, path):
        share = Picture(program.render(path, "--size", "256x256", *options)[0]).share()
        if abs(share - percent) > 0.5:
            yield f"{' '.join(options)} {share:.2f} % of the picture are lit, expected {percent}".strip()

    return check


def visible(path_options):
    """Something is seen, and nothing is warned of, under each of these options."""

    def check(program, path):
        for options in path_options:
            picture, said, _ = program.render(path, *options)
            share = Picture(picture).share()
            if share < 1 or any(line.startswith("warning") for line in said):
                yield f"{' '.join(map(str, options))}: {share:.2f} % of the picture are lit: {said}"

    return check


def labels(count, greatest):
    """The scene `labels` by default, every label in a colour of its own and in the picture's legend."""

    def check(program, path):
        found = program.inspect(path)
        if found["scene"] != "labels":
            yield f"scene {found['scene']}, expected labels"
            return
        picture, _, legend = program.render(path)
        if picture != program.render(path, "--scene", "labels")[0]:
            yield "the default picture is not that of --scene labels"
        if legend["labels"] != found["labels"]:
            yield "the legend of inspect is not that of render"
        lines = found["labels"]
        colours = {line["colour"] for line in lines}
        most = max(line["label"] for line in lines)
        if (len(lines), len(colours - {"#000000"}), most) != (count, count, greatest):
            yield f"{len(lines)} labels up to {most} in {len(colours)} colours, expected {count} up to {greatest}"

    return check


def same_picture(other):
    def check(program, path):
        if program.render(path)[0] != program.render(other)[0]:
            yield f"the picture is not that of {other}"

    return check


def transmitted(scene, views):
    """The centre of the picture: 255 (1 - 0.98^L) for a ray of L mm; up to 6 more at the coarse planes of the scene."""

    def check(program, path):
        for azimuth, elevation, length in views:
            wanted = 255 * (1 - 0.98**length)
            for more, options in ((6, ("--planes", 1)), (1, ("--planes", 16))):
                view = ("--azimuth", azimuth, "--elevation", elevation)
                picture, _, _ = program.render(path, "--scene", scene, *view, *options)
                centre = Picture(picture).centre()
                if not -1 <= centre - wanted <= more:
                    yield f"centre {centre} from {azimuth}, {elevation} at {options[1]} planes, expected {wanted:.1f} to {wanted + more:.1f}"

    return check


def one_scale(scene):
    """A cube is as high in every frame, as wide as high from its sides and the root of 2 times that from its edges.

    To 1.5 %: a ray's width at each end is seen or lies outside of the picture.
    """

    def check(program, path):
        for size in ((), ("--size", "300x260"), ("--size", "640x640")):
            extents = [frame.extent() for frame in program.turn(path, 8, "--scene", scene, *size)]
            heights = [rows for _, rows in extents]
            if max(heights) - min(heights) > 1 or min(heights) < 33:
                yield f"{' '.join(size)}: heights {heights}, expected one of 33 pixels or more, to a pixel"
            for n, (columns, rows) in enumerate(extents):
                if abs(columns / rows / (1, math.sqrt(2))[n % 2] - 1) > 0.015:
                    yield f"{' '.join(size)}: frame {n} is {columns} x {rows}"

    return check


def library(source, test, words):
    """A fact about the library, held by a test of its own that says these words."""

    def check(_program, _path):
        text = (REPOSITORY / source).read_text()
        body = re.search(r"#\[test\]\n\s*fn " + test + r"\(\) \{\n(.*?)\n    \}\n", text, re.S)
        if body is None:
            yield f"{source} has no test {test}"
        else:
            yield from (f"{source}, {test}: does not say `{word}`" for word in words if word not in body[1])

    check.told = f"`cargo test -p slicecast {test}`"
    return check


HEAD, SIGNED = "550018c8", "2531f710"
DENSE = dict(crc32=HEAD, range=[24, 2424])
CT = dict(crc32=HEAD, range=[-1000, 1400], modality="CT", scene="headsq")
CHECKS = {
    "tiff/ij-two-channels.tif": [facts(**DENSE, notes=["channel 1 of 2", "--channel"]), facts(("--channel", 2))],
    "tiff/ij-one-directory.tif": [facts(**DENSE, value_type="uint16", notes=["16 images behind one directory"])],
    "tiff/ij-signed16.tif": [facts(range=[-1000, 1400], notes=["calibration", "-32768"])],
    "tiff/ij-no-unit.tif": [facts(**DENSE, spacing=(0.5, 0.5, 2), notes=["no unit"], without=["no spacing"]), ratio((0.5, 0.5, 2))],
    "tiff/ij-unit-latin1.tif": [facts(**DENSE, spacing=(0.0005, 0.0005, 0.002), notes=["Latin-1"])],
    "tiff/ome-sizes.ome.tif": [facts(**DENSE, spacing=(0.0005, 0.0005, 0.002), without=["no spacing"])],
    "tiff/tif-white-is-zero-f32.tif": [facts(spacing=(1, 1, 1), range=[24, 2424], value_type="float", notes=["as stored"])],
    "tiff/folder-with-apple-double": [facts(**DENSE, spacing=(1, 1, 1), notes=["16 files whose names begin with a dot are passed over"])],
    "dicom/plain": [facts(**CT, notes=[], orientation="LPS (in the file: LPS)")],
    "dicom/with-dose-page": [facts(**CT, notes=["99-dose.dcm", "passed over"])],
    "dicom/orientation-jitter-even": [facts(**CT)],
    "dicom/rounded-positions-2": [facts(**CT, spacing=(1.4, 1.4, 1 / 3), within=3e-4)],
    "dicom/excess-padding": [facts(**CT, notes=["padding", "60 bytes"])],
    "dicom/cd": [facts(**CT, notes=["PT000000/ST000000/SE000000"])],
    "dicom/cd/DICOMDIR": [facts(**CT, notes=["PT000000/ST000000/SE000000"])],
    "dicom/two-phases": [refused("2 phases of 16 slices", "`--phase N`"), facts(("--phase", 1)), facts(("--phase", 2))],
    "dicom/with-localizer": [facts(**CT, notes=["loc1.dcm", "loc2.dcm"])],
    "nifti/nii-good.nii.gz": [facts(crc32=SIGNED, range=[-1000, 1400], value_type="int16")],
    "nifti/nii-nan-background.nii.gz": [refused("is NaN", "`--nan background`"), facts(("--nan", "background"), range=[0.3, 14], notes=["NaN"])],
    "nifti/nii-mr-plain.nii.gz": [facts(dims=(40, 44, 32), spacing=(0.7, 0.7, 0.7), scene="mr"), lit(23)],
    "nifti/nii-mr-hot-voxel.nii.gz": [facts(dims=(40, 44, 32), spacing=(0.7, 0.7, 0.7), scene="mr", clipped=[0, 1]), lit(23)],
    "nifti/nii-labels-12.nii.gz": [facts(dims=(40, 44, 32), spacing=(0.7, 0.7, 0.7)), labels(12, 13)],
    # The manifest's 27 % are of interpolated labels, which reach into the background as labels that are not there.
    "nifti/nii-labels-98.nii.gz": [
        facts(dims=(40, 44, 32), spacing=(0.7, 0.7, 0.7)),
        labels(98, 2035),
        lit(27, "--interpolation", "linear"),
        lit(24.8),
    ],
    "nrrd/nrrd-millimetres.nrrd": [facts(crc32=SIGNED)],
    "nrrd/nrrd-metres.nrrd": [facts(crc32=SIGNED, notes=["brought to millimetres"]), same_picture("nrrd/nrrd-millimetres.nrrd")],
    "nrrd/many-files/list.nhdr": [facts(crc32=SIGNED, notes=["16 files"])],
    "nrrd/one-slice.nrrd": [
        facts(dims=(20, 22, 1), spacing=(1.4, 1.4, 5), notes=["one slice along z has no thickness", "drawn twice"], warnings=[]),
        visible([("--elevation", degrees) for degrees in range(10, 60, 10)]),
    ],
    "render/box-anisotropic.nrrd": [
        facts(dims=(48, 40, 16), spacing=(1, 1, 4)),
        transmitted("render/box.toml", [(0, 0, 39), (90, 0, 47), (0, 90, 60), (45, 0, 39 * math.sqrt(2))]),
    ],
    "render/cube.nrrd": [facts(dims=(33, 33, 33), spacing=(1, 1, 1)), one_scale("render/cube.toml")],
    "library/spacing.rs": [
        library(
            "core/src/view.rs",
            "angles_and_spacings_that_are_none_are_refused",
            ["[f32::NAN, f32::INFINITY, -1.0, 0.0", "assert_eq!(View::from_angles(0.5, 0.2, spacing), refused"],
        )
    ],
}


def same_words(program, path):
    """`render` says the notes and warnings that `inspect` tells."""
    found = program.inspect(path)
    _, said, _ = program.render(path)
    for kind in ("note", "warning"):
        told = [line.removeprefix(f"{kind}: ") for line in said if line.startswith(f"{kind}: ")]
        if told != found[f"{kind}s"]:
            yield f"{kind}s of render {told}, of inspect {found[f'{kind}s']}"


def faults_of(program, path, kind, checks):
    loads = any(getattr(check, "loads", False) for check in checks)
    if kind == "must-load" and not loads:
        yield "must load, and no check says how"
    for check in [*checks, same_words] if loads else checks:
        try:
            yield from check(program, path)
        except (AssertionError, KeyError, TypeError, subprocess.TimeoutExpired) as error:
            yield f"{type(error).__name__}: {error}"


def main(binary, folder):
    program = Program(binary, folder)
    with open(pathlib.Path(folder) / "MANIFEST.tsv", newline="") as file:
        lines = {line["path"]: line["class"] for line in csv.DictReader(file, delimiter="\t")}
    bad = 0
    for path in [*lines, *(path for path in CHECKS if path not in lines)]:
        if path not in CHECKS:
            faults = ["no check"]
        elif path not in lines:
            faults = ["no line in the manifest"]
        else:
            faults = list(faults_of(program, path, lines[path], CHECKS[path]))
        bad += bool(faults)
        told = next((check.told for check in CHECKS.get(path, []) if hasattr(check, "told")), "")
        line = "; ".join(faults) or f"ok {told}"
        print(f"{path:36} {' '.join(line.split())}", flush=True)
    print(f"\n{len(lines)} lines, {'all as expected' if not bad else f'{bad} not as expected'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))

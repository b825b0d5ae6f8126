"""Feeds malformed files to the program: each must end with exit code 2, one line that names file and fault, no picture,
within 10 seconds and 512 MiB.

    python bad_inputs.py PATH/TO/slicecast        (numpy not needed; standard library only, Linux)
"""
import gzip, json, os, pathlib, resource, struct, subprocess, sys, tempfile, time, zlib

NRRD = "NRRD0004\ntype: {type}\ndimension: 3\nsizes: {sizes}\nspacings: {spacings}\nendian: little\nencoding: {encoding}\n"
META = "NDims = 3\nDimSize = {sizes}\nElementSpacing = {spacings}\nElementType = {type}\n{more}ElementDataFile = {file}\n"


def nrrd(data, type="uint8", sizes="4 4 4", spacings="1 1 1", encoding="raw", more=""):
    return (NRRD.format(type=type, sizes=sizes, spacings=spacings, encoding=encoding) + more + "\n").encode() + data


def meta(data=b"", type="MET_UCHAR", sizes="4 4 4", spacings="1 1 1", more="", file="LOCAL"):
    return META.format(type=type, sizes=sizes, spacings=spacings, more=more, file=file).encode() + data


def nifti(dim=(3, 4, 4, 4, 1, 1, 1, 1), kind=2, offset=352.0, size=348, data=bytes(64)):
    h = bytearray(352)
    struct.pack_into("<i", h, 0, size)
    struct.pack_into("<8h", h, 40, *dim)
    struct.pack_into("<2h", h, 70, kind, 8)
    struct.pack_into("<8f", h, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<f", h, 108, offset)
    h[344:348] = b"n+1\0"
    return bytes(h) + data


def dicom(*elements, syntax=b"1.2.840.10008.1.2.1", medium=b""):
    return bytes(128) + b"DICM" + medium + element(2, 16, b"UI", syntax) + b"".join(elements)


def element(group, number, kind, value):
    if kind in (b"OW", b"SQ", b"UN"):
        return struct.pack("<2H2sHI", group, number, kind, 0, len(value)) + value
    return struct.pack("<2H2sH", group, number, kind, len(value)) + value


def slice_of(z, pixels=bytes(32), y=0, more=(), syntax=b"1.2.840.10008.1.2.1"):
    us = lambda n, v: element(0x28, n, b"US", struct.pack("<H", v))
    return dicom(*more, element(0x20, 0x32, b"DS", b"0\\%3.1f\\%4.1f" % (y, z)), element(0x20, 0x37, b"DS", b"1\\0\\0\\0\\1\\0 "), us(2, 1),
                 us(0x10, 4), us(0x11, 4), us(0x100, 16), us(0x101, 12), us(0x102, 11), us(0x103, 0), element(0x7FE0, 0x10, b"OW", pixels), syntax=syntax)


def frames_of(stated, described, pixels):
    """A file that states so many frames, describes others and has so many bytes of pixels."""
    place = lambda z: element(0x20, 0x9113, b"SQ", item(element(0x20, 0x32, b"DS", b"0\\0\\%d " % z)))
    groups = element(0x5200, 0x9230, b"SQ", b"".join(item(place(z)) for z in range(described)))
    return slice_of(0, bytes(pixels), more=[element(0x28, 8, b"IS", stated), groups])


def directory(*names):
    """A DICOMDIR that names these files."""
    records = b"".join(item(element(4, 0x1500, b"CS", name)) for name in names)
    return dicom(element(4, 0x1220, b"SQ", records), medium=element(2, 2, b"UI", b"1.2.840.10008.1.3.10"))


def zarr(chunk, **changes):
    """A store of one chunk of 4 x 4 x 4 bytes."""
    metadata = {"zarr_format": 2, "shape": [4, 4, 4], "chunks": [4, 4, 4], "dtype": "|u1", "compressor": None, "fill_value": 0, "order": "C", "filters": None, **changes}
    files = {".zarray": json.dumps(metadata).encode()} | ({"0.0.0": chunk} if chunk is not None else {})
    return lambda p: folder(p, files)


def image(axes="zyx", path="0"):
    """An image of one level that is not there."""
    multiscale = {"axes": [{"name": name, "type": "space"} for name in axes], "datasets": [{"path": path}]}
    files = {".zgroup": b'{"zarr_format": 2}', ".zattrs": json.dumps({"multiscales": [multiscale]}).encode()}
    return lambda p: folder(p, files)


def item(data):
    return struct.pack("<2HI", 0xFFFE, 0xE000, len(data)) + data


# The header of lossless JPEG, 4 x 4 pixels of 12 bits with a table of one code, and the beginning of its scan.
JPEG = b"\xff\xd8\xff\xc3\0\x0b\x0c\0\x04\0\x04\x01\x01\x11\0\xff\xc4\0\x14\0\x01" + bytes(16)
SCAN = b"\xff\xda\0\x08\x01\x01\0\x01\0\0\x12"


def packed(syntax, frame):
    """The same slice with one packed frame, or none."""
    plain = slice_of(0, b"", syntax=syntax)[:-12]
    return plain + struct.pack("<2H2sHI", 0x7FE0, 0x10, b"OB", 0, 0xFFFFFFFF) + item(b"") + (b"" if frame is None else item(frame)) + struct.pack("<2HI", 0xFFFE, 0xE0DD, 0)


def tiff(description, pages):
    """Pages of 4 x 4 bytes, the first with a description."""
    out, link = bytearray(b"II*\0\0\0\0\0" + description + b"\0" + bytes(16)), 4
    for page in range(pages):
        tags = [(256, 3, 1, 4), (257, 3, 1, 4), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 8 + len(description) + 1), (279, 4, 1, 16)]
        tags += [(270, 2, len(description) + 1, 8)] if page == 0 else []
        struct.pack_into("<I", out, link, len(out))
        out += struct.pack("<H", len(tags)) + b"".join(struct.pack("<2H2I", *tag) for tag in sorted(tags))
        link = len(out)
        out += bytes(4)
    return bytes(out)


def folder(path, files):
    path.mkdir()
    for name, data in files.items():
        (path / name).write_bytes(data)


def cases(root):
    """Name, file name, and bytes, or a function that makes the file at a path."""
    nan = struct.pack("<64f", *[0.0] * 9, float("nan"), *[0.0] * 54)
    nested = b"".join(struct.pack("<2H2sHI2HI", 8, 0x1110, b"SQ", 0, 0xFFFFFFFF, 0xFFFE, 0xE000, 0xFFFFFFFF) for _ in range(50000))
    yield "empty file", "a.nrrd", b""
    yield "no known format", "a.bin", b"hello world"
    yield "folder without images", "a", lambda p: folder(p, {"x.txt": b"x"})
    yield "pipe", "a.nii", os.mkfifo
    yield "device", "zero", lambda p: p.symlink_to("/dev/zero")
    yield "missing file", "none.nii", lambda p: None
    yield "NRRD truncated", "a.nrrd", nrrd(bytes(63))
    yield "NRRD too long", "a.nrrd", nrrd(bytes(65))
    yield "NRRD huge size", "a.nrrd", nrrd(bytes(64), sizes="8192 8192 32")
    yield "NRRD huge side", "a.nrrd", nrrd(bytes(64), sizes="99999999999 4 4")
    yield "NRRD size 0", "a.nrrd", nrrd(b"", sizes="4 0 4")
    yield "NRRD NaN voxel", "a.nrrd", nrrd(nan, type="float")
    yield "NRRD zero spacing", "a.nrrd", nrrd(bytes(64), spacings="1 0 1")
    yield "NRRD negative spacing", "a.nrrd", nrrd(bytes(64), spacings="1 1 -2")
    yield "NRRD denormal spacing", "a.nrrd", nrrd(bytes(64), spacings="1 1e-320 1")
    yield "NRRD values to 2^64", "a.nrrd", nrrd(struct.pack("<2Q", 0, 2**64 - 1), type="uint64", sizes="2 1 1")
    yield "NRRD sizes not text", "a.nrrd", b"NRRD0004\ndimension: 3\ntype: uint8\nsizes: \xff\xfe\n\n"
    yield "NRRD endless header", "a.nrrd", b"NRRD0004\n#" + b"x" * (1 << 21)
    yield "NRRD gzip bomb", "a.nrrd", nrrd(gzip.compress(bytes(1 << 27)), encoding="gzip")
    yield "NRRD gzip damaged", "a.nrrd", nrrd(gzip.compress(bytes(64))[:-4], encoding="gzip")
    yield "NRRD claims 16 GiB packed", "a.nrrd", nrrd(gzip.compress(bytes(64)), type="double", sizes="8192 8192 32", encoding="gzip")
    yield "NRRD data file elsewhere", "a.nhdr", nrrd(b"", more="data file: ../../etc/passwd\n")
    yield "NRRD list leads elsewhere", "a.nhdr", nrrd(b"").rstrip() + b"\ndata file: LIST\n" + b"../../etc/passwd\n" * 4
    yield "NRRD list too short", "a.nhdr", nrrd(b"").rstrip() + b"\ndata file: LIST\na.raw\n"
    yield "NRRD pattern without end", "a.nhdr", nrrd(b"", more="data file: s%d.raw 0 999999999 1\n")
    yield "NRRD data file is a folder", "a.nhdr", lambda p: ((p.parent / "sub").mkdir(), p.write_bytes(nrrd(b"", more="data file: sub\n")))
    yield "NRRD sheared axes", "a.nrrd", nrrd(bytes(64)).replace(b"spacings: 1 1 1", b"space directions: (1,0,0) (0.5,1,0) (0,0,1)")
    yield "NIfTI truncated", "a.nii", nifti()[:-1]
    yield "NIfTI wrong header size", "a.nii", nifti(size=1543569408 + 1)
    yield "NIfTI lying dimensions", "a.nii", nifti(dim=(3, 4000, 4000, 100, 1, 1, 1, 1))
    yield "NIfTI negative dimension", "a.nii", nifti(dim=(3, 4, -4, 4, 1, 1, 1, 1))
    yield "NIfTI several volumes", "a.nii", nifti(dim=(4, 4, 4, 4, 9, 1, 1, 1))
    yield "NIfTI colour", "a.nii", nifti(kind=128)
    yield "NIfTI NaN offset", "a.nii", nifti(offset=float("nan"))
    yield "MetaImage wrong count", "a.mha", meta(bytes(63))
    yield "MetaImage link out", "a.mhd", lambda p: ((p.parent / "l.raw").symlink_to("/etc/passwd"), p.write_bytes(meta(file="l.raw")))
    yield "MetaImage zlib bomb", "a.mha", meta(zlib.compress(bytes(1 << 27)), more="CompressedData = True\n")
    yield "MetaImage list leads elsewhere", "a.mhd", meta(b"../../etc/passwd\n" * 4, file="LIST")
    yield "MetaImage without data", "a.mhd", b"NDims = 3\n"
    yield "DICOM truncated", "a.dcm", slice_of(0)[:-7]
    yield "DICOM lying length", "a.dcm", dicom(struct.pack("<2H2sHI", 9, 1, b"UN", 0, 0xFFFFFFF0))
    yield "DICOM endless nesting", "a.dcm", dicom(nested)
    yield "DICOM JPEG XL", "a.dcm", slice_of(0, syntax=b"1.2.840.10008.1.2.4.110")
    yield "DICOM cut JPEG 2000", "a.dcm", packed(b"1.2.840.10008.1.2.4.90", b"\xff\x4f\xff\x51\0\x29" + struct.pack(">H8IH3B", 0, 4, 4, 0, 0, 4, 4, 0, 0, 1, 15, 1, 1))
    yield "DICOM cut JPEG", "a.dcm", packed(b"1.2.840.10008.1.2.4.70", JPEG + SCAN)
    yield "DICOM JPEG of another size", "a.dcm", packed(b"1.2.840.10008.1.2.4.70", JPEG.replace(b"\0\x04\0\x04", b"\xff\xff\xff\xff") + SCAN)
    yield "DICOM cut JPEG-LS", "a.dcm", packed(b"1.2.840.10008.1.2.4.80", b"\xff\xd8\xff\xf7\0\x0b\x0c\0\x04\0\x04\x01\x01\x11\0\xff\xda\0\x08\x01\x01\0\0\0\0\x12")
    yield "DICOM cut RLE", "a.dcm", packed(b"1.2.840.10008.1.2.5", struct.pack("<16I", 2, 64, 66, *[0] * 13) + b"\xf1\0\x0f\x01")
    yield "DICOM packed frame missing", "a.dcm", packed(b"1.2.840.10008.1.2.5", None)
    yield "DICOM frames truncated", "a.dcm", frames_of(b"3 ", 3, 80)
    yield "DICOM frames not described", "a.dcm", frames_of(b"4 ", 3, 128)
    yield "DICOM negative frame count", "a.dcm", frames_of(b"-3", 3, 96)
    yield "DICOM frame count 0", "a.dcm", frames_of(b"0 ", 0, 32)
    yield "DICOM huge frame count", "a.dcm", frames_of(b"2147483647", 3, 96)
    yield "DICOM endless frame count", "a.dcm", frames_of(b"9" * 40, 3, 96)
    yield "DICOMDIR of files elsewhere", "DICOMDIR", directory(b"..\\..\\ETC\\PASSWD", b"/etc/passwd ")
    yield "folder of such a DICOMDIR", "d", lambda p: folder(p, {"DICOMDIR": directory(b"..\\A.DCM"), "../a.dcm": slice_of(0)})
    yield "DICOM tilted gantry", "d", lambda p: folder(p, {f"{i}.dcm": slice_of(2.0 * i, y=0.5 * i) for i in range(4)})
    yield "DICOM two phases", "d", lambda p: folder(p, {f"{i}.dcm": slice_of(i // 2, more=[element(0x20, 0x12, b"IS", b"%d " % (i % 2 + 1))]) for i in range(4)})
    yield "DICOM missing slice", "d", lambda p: folder(p, {f"{i}.dcm": slice_of(2.0 * i) for i in (0, 1, 2, 4, 5)})
    yield "DICOM uneven slices", "d", lambda p: folder(p, {f"{i}.dcm": slice_of(z) for i, z in enumerate((0, 2, 4.7, 6.7))})
    yield "DICOM doubled slices", "d", lambda p: folder(p, {f"{i}.dcm": slice_of(i // 2) for i in range(4)})
    yield "DICOM short pixels", "d", lambda p: folder(p, {"0.dcm": slice_of(0), "1.dcm": slice_of(1, bytes(30))})
    yield "TIFF damaged", "a.tif", b"II*\0\x08\0\0\0\xff\xff" + bytes(40)
    yield "TIFF fewer pages than stated", "a.tif", tiff(b"ImageJ=1.54f\nimages=6\nchannels=2\nslices=3\n", 4)
    yield "TIFF one page of many", "a.tif", tiff(b"ImageJ=1.54f\nimages=16\nslices=16\n", 1)
    yield "TIFF OME-XML damaged", "a.tif", tiff(b"<?xml version='1.0'?><OME><Image>", 2)
    yield "TIFF OME-XML bomb", "a.tif", tiff(b"<!DOCTYPE a [<!ENTITY b 'xxxxxxxx'>]><OME>&b;</OME>", 2)
    yield "Zarr chunk truncated", "a.zarr", zarr(bytes(63))
    yield "Zarr without chunks", "a.zarr", zarr(None)
    yield "Zarr zlib bomb", "a.zarr", zarr(zlib.compress(bytes(1 << 28)), compressor={"id": "zlib"})
    yield "Zarr LZ4 length lies", "a.zarr", zarr(struct.pack("<I", 64) + b"\xff", compressor={"id": "lz4"})
    yield "Zarr blosc cut", "a.zarr", zarr(struct.pack("<4B3I", 2, 1, 0x21, 1, 64, 64, 60), compressor={"id": "blosc"})
    yield "Zarr huge chunk", "a.zarr", zarr(bytes(64), chunks=[1 << 40, 4, 4])
    yield "Zarr huge shape", "a.zarr", zarr(bytes(64), shape=[8192, 8192, 8192])
    yield "Zarr huge side", "a.zarr", zarr(bytes(64), shape=[4, 4, 1 << 40], chunks=[4, 4, 1 << 20])
    yield "Zarr other codec", "a.zarr", zarr(bytes(64), compressor={"id": "lzma"})
    yield "Zarr other type", "a.zarr", zarr(bytes(64), dtype="<c8")
    yield "Zarr axes too many", "a.zarr", zarr(bytes(64), shape=[2, 2, 4, 4, 4], chunks=[1, 1, 4, 4, 4])
    yield "Zarr metadata no JSON", "a.zarr", lambda p: folder(p, {"zarr.json": b"{" * 1000})
    yield "Zarr without metadata", "a.zarr", lambda p: folder(p, {"0.0.0": bytes(64)})
    yield "Zarr level missing", "a.zarr/7", lambda p: image()(p.parent)
    yield "Zarr level not there", "a.zarr", image()
    yield "Zarr level elsewhere", "a.zarr", image(path="../b.zarr")
    yield "raw without shape", "a.raw", bytes(64)
    yield "raw sidecar lies", "a.raw", lambda p: (p.write_bytes(bytes(64)), pathlib.Path(f"{p}.toml").write_text("size = [4, 4, 5]\ntype = 'uint8'"))


def main(binary):
    bad = 0
    print("| input | message | s | MiB |\n|---|---|---|---|")
    for name, file, make in cases(None):
        with tempfile.TemporaryDirectory() as root:
            root = pathlib.Path(root)
            path, picture = root / file, root / "out.png"
            make(path) if callable(make) else path.write_bytes(make)
            before = time.monotonic()
            limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
            run = subprocess.Popen([binary, "render", str(path), "-o", str(picture)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=limit)
            text = run.stderr.read()
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            seconds, memory = time.monotonic() - before, usage.ru_maxrss / 1024
            shown = text.strip().replace(str(root) + "/", "")
            good = run.returncode == 2 and len(text.strip().splitlines()) == 1 and not picture.exists() and seconds < 10 and memory < 512
            bad += not good
            flag = "" if good else f" **code {run.returncode}**"
            print(f"| {name} | `{shown}`{flag} | {seconds:.2f} | {memory:.0f} |")
    print(f"\n{'all as expected' if not bad else f'{bad} not as expected'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

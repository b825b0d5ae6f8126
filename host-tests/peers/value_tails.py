"""How far the tails of volumes reach and how equal neighbours are: the figures behind the default mapping.

    python value_tails.py FILE...        (standard library only; NIfTI, NRRD and MetaImage of up to 32-bit values)

tail: how far the greatest (or the least) value lies beyond the middle 99.98 % of the voxels, in ranges of these.
equal: share of equal values among neighbours along x of which neither is the least value.
"""
import array, gzip, pathlib, struct, sys, zlib

NRRD = {"short": "h", "int16": "h", "ushort": "H", "uint16": "H", "unsigned short": "H", "uchar": "B", "uint8": "B", "unsigned char": "B", "int": "i", "float": "f"}
META = {"MET_UCHAR": "B", "MET_SHORT": "h", "MET_USHORT": "H", "MET_INT": "i", "MET_FLOAT": "f"}


def unpacked(data):
    return gzip.decompress(data) if data[:2] == b"\x1f\x8b" else zlib.decompress(data) if data[:1] == b"\x78" else data


def read(path):
    """Width and values of a volume."""
    data = path.read_bytes()
    if ".nii" in path.name:
        data = unpacked(data)
        size, kind = struct.unpack("<3h", data[42:48]), struct.unpack("<h", data[70:72])[0]
        code, data = {2: "B", 4: "h", 8: "i", 16: "f", 512: "H"}[kind], data[int(struct.unpack("<f", data[108:112])[0]):]
        big = False
    else:
        is_nrrd = data.startswith(b"NRRD")
        head, _, rest = data.partition(b"\n\n") if is_nrrd else (data, b"", b"")
        lines = [line.partition(":" if is_nrrd else "=") for line in head.decode("latin-1").splitlines()]
        fields = {key.strip(): value.strip() for key, _, value in lines}
        file = fields.get("data file", fields.get("datafile", fields.get("ElementDataFile")))
        data = (path.parent / file).read_bytes() if file else rest
        packed = fields.get("encoding", "").startswith("gz") or fields.get("CompressedData") == "True"
        data = unpacked(data) if packed else data
        size = [int(side) for side in fields["sizes" if is_nrrd else "DimSize"].split()]
        code = NRRD[fields["type"]] if is_nrrd else META[fields["ElementType"]]
        big = fields.get("endian") == "big"
    values = array.array(code)
    values.frombytes(data[: size[0] * size[1] * size[2] * values.itemsize])
    if big:
        values.byteswap()
    return size[0], values


def main(paths):
    print("| volume | tail above | tail below | equal |\n|---|---|---|---|")
    for path in map(pathlib.Path, paths):
        width, values = read(path)
        ordered = sorted(values)
        rank = max(1, int(1e-4 * len(ordered)))
        least, low, high, most = ordered[0], ordered[rank], ordered[-1 - rank], ordered[-1]
        spread = high - low or 1
        pairs = equal = 0
        for row in range(0, len(values), width):
            for a, b in zip(values[row : row + width - 1], values[row + 1 : row + width]):
                if a != least and b != least:
                    pairs += 1
                    equal += a == b
        print(f"| {path.name} | {(most - high) / spread:.2f} | {(low - least) / spread:.2f} | {equal / max(pairs, 1):.2f} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

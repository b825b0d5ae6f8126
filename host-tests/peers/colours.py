"""Makes a volume of colours and opacities, NRRD of 4 values a voxel, of a volume of bytes: colours and opacities by ranges of values.

    python colours.py bonsai-256.nii.gz bonsai-rgba.nrrd        (NIfTI, gzip, uint8; standard library only)
"""
import gzip, struct, sys


def entry(value):
    if value < 17:
        return 0, 0, 0, 0
    if value < 50:
        return 60 + 2 * (value - 17), 160, 40, 3 * (value - 17) // 2
    if value < 90:
        return 120, 80, 40, 100
    if value < 150:
        return 90, 70, 60, 140
    return 190, 190, 180, 254


def main(source, target):
    with gzip.open(source) as file:
        raw = file.read()
    x, y, z = struct.unpack_from("<3h", raw, 42)
    offset = int(struct.unpack_from("<f", raw, 108)[0])
    values = raw[offset : offset + x * y * z]
    voxels = bytearray(4 * len(values))
    for channel in range(4):
        voxels[channel::4] = values.translate(bytes(entry(value)[channel] for value in range(256)))
    head = f"NRRD0005\ntype: uint8\ndimension: 4\nsizes: 4 {x} {y} {z}\nkinds: RGBA-color domain domain domain\n"
    with open(target, "wb") as file:
        file.write(head.encode() + b"spacings: nan 1 1 1\nencoding: raw\n\n" + voxels)


main(*sys.argv[1:])

"""Writes the Zarr stores that the tests of slicecast-volume read, as zarr-python does: sim/volume/src/zarr/tests/stores.json.gz.

    pip install zarr==3.1.6 numcodecs==0.16.6 numpy
    python host-tests/peers/zarr_stores.py sim/volume/src/zarr/tests/stores.json.gz

The file is one JSON object, packed: the path of each file of each store, and its bytes in hexadecimal. Voxel (x, y, z) has the value
(3 x x + 5 y + 40 z + x y) % 97 minus 20 in types with a sign, and a half of that more in types of floats; the channel adds 100.
"""

import gzip
import json
import pathlib
import sys
import tempfile

import numcodecs
import numpy as np
import zarr
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, ShardingCodec, TransposeCodec, ZstdCodec

SHAPE = (5, 6, 9)
CHUNKS = (3, 6, 5)
# Of several blocks of blosc, some of which are split, and a rest.
LONG = (9, 8, 10)


def values(dtype, shape=SHAPE):
    z, y, x = np.indices(shape)
    v = (3 * x * x + 5 * y + 40 * z + x * y) % 97
    kind = np.dtype(dtype).kind
    if kind == "f":
        return (v * 1.5 - 20).astype(dtype)
    return (v - 20 if kind == "i" else v).astype(dtype)


def array(folder, name, data, chunks=CHUNKS, **options):
    made = zarr.create_array(store=str(folder / name), shape=data.shape, dtype=data.dtype, chunks=chunks, **options)
    made[...] = data
    return made


def second(folder, name, dtype, compressor=None, separator=".", shape=SHAPE, chunks=CHUNKS, **options):
    options.setdefault("fill_value", 0)
    keys = {"name": "v2", "separator": separator}
    array(folder, name, values(dtype, shape), chunks, zarr_format=2, compressors=compressor, filters=None,
          chunk_key_encoding=keys, **options)


def third(folder, name, dtype, codecs, shape=SHAPE, chunks=CHUNKS, keys=None, fill_value=0, data=None, attributes=None, **more):
    serializer = codecs[0]
    data = values(dtype, shape) if data is None else data
    options = dict(zarr_format=3, serializer=serializer, compressors=codecs[1:], fill_value=fill_value, **more)
    if keys:
        options["chunk_key_encoding"] = keys
    return array(folder, name, data, chunks, attributes=attributes or {}, **options)


def plain(folder):
    second(folder, "u2.zarr", "<u2")
    second(folder, "u1-gzip.zarr", "|u1", numcodecs.GZip(5), "/")
    second(folder, "i2-big-zlib.zarr", ">i2", numcodecs.Zlib(5))
    second(folder, "i4-zstd-f.zarr", "<i4", numcodecs.Zstd(3), order="F")
    second(folder, "f4-lz4.zarr", "<f4", numcodecs.LZ4())
    second(folder, "f8-bz2.zarr", ">f8", numcodecs.BZ2(5))
    second(folder, "i1.zarr", "|i1")
    second(folder, "u4-big.zarr", ">u4", numcodecs.Zstd(1, checksum=True))
    second(folder, "i8.zarr", "<i8", numcodecs.Zlib(9))
    second(folder, "u8.zarr", ">u8", numcodecs.Zlib(9))
    shuffles = {"none": 0, "bytes": 1, "bits": 2}
    for packer, shuffle, dtype in [("lz4", "bytes", "<u2"), ("lz4hc", "bits", "<i4"), ("blosclz", "bytes", "<u2"),
                                   ("blosclz", "bits", "<u2"), ("zlib", "none", "<f4"), ("zlib", "bytes", "<f8"),
                                   ("zstd", "bytes", "<i2"), ("zstd", "bits", "|u1")]:
        codec = numcodecs.Blosc(packer, 5, shuffles[shuffle], blocksize=512)
        second(folder, f"blosc-{packer}-{shuffle}.zarr", dtype, codec, shape=LONG, chunks=LONG)
    # Incompressible, which blosc leaves plain.
    noise = np.random.default_rng(1).integers(0, 256, SHAPE).astype("|u1")
    array(folder, "blosc-plain.zarr", noise, zarr_format=2, compressors=numcodecs.Blosc("lz4", 5, 0), filters=None)
    # Chunks of nothing but the fill value are not written.
    holes = values("<u2")
    holes[:3, :, 5:] = 7
    array(folder, "missing.zarr", holes, zarr_format=2, compressors=None, filters=None, fill_value=7)


def threes(folder):
    little, big = BytesCodec(endian="little"), BytesCodec(endian="big")
    third(folder, "3-u2.zarr", "uint16", [little])
    third(folder, "3-i2-big-gzip.zarr", "int16", [big, GzipCodec(level=5)])
    third(folder, "3-f4-zstd.zarr", "float32", [little, ZstdCodec(level=3, checksum=True)])
    third(folder, "3-f8-crc.zarr", "float64", [little, Crc32cCodec()])
    third(folder, "3-i4-crc-zstd.zarr", "int32", [big, ZstdCodec(level=3), Crc32cCodec()])
    third(folder, "3-u1-blosc.zarr", "uint8", [BytesCodec(endian=None), BloscCodec(cname="zstd", clevel=3, shuffle="bitshuffle")])
    third(folder, "3-v2-keys.zarr", "uint16", [little], keys={"name": "v2", "separator": "."})
    third(folder, "3-dots.zarr", "uint16", [little], keys={"name": "default", "separator": "."})
    third(folder, "3-turned.zarr", "uint16", [little], filters=[TransposeCodec(order=(2, 0, 1))])
    inner = dict(chunk_shape=(2, 3, 4))
    end = ShardingCodec(codecs=[little, ZstdCodec()], **inner)
    third(folder, "3-sharded.zarr", "uint16", [end], chunks=(4, 6, 8))
    start = ShardingCodec(codecs=[TransposeCodec(order=(1, 2, 0)), big, GzipCodec()], index_location="start",
                          index_codecs=[BytesCodec(endian="big")], **inner)
    third(folder, "3-sharded-start.zarr", "int32", [start], chunks=(4, 6, 8))
    holes = values("float32")
    holes[2:4, :3, :4] = -7.5
    hollow = ShardingCodec(codecs=[little], **inner)
    third(folder, "3-sharded-missing.zarr", "float32", [hollow], chunks=(4, 6, 8), fill_value=-7.5, data=holes)
    third(folder, "3-named.zarr", "uint16", [little], data=values("uint16").transpose(2, 0, 1), chunks=(5, 3, 6),
          dimension_names=["x", "z", "y"])


def image(folder, name, version, sharded=False):
    """Two levels of five axes, the second of every other voxel."""
    root = zarr.open_group(str(folder / name), mode="w", zarr_format=2 if version == "0.4" else 3)
    data = np.stack([np.stack([values("<u2") + 100 * c + 1000 * t for c in range(2)]) for t in range(2)])
    levels = [data, data[:, :, ::2, ::2, ::2]]
    for level, array_data in enumerate(levels):
        options = dict(chunks=(1, 2, 3, 6, 5))
        if sharded:
            options = dict(chunks=(1, 1, 2, 3, 3), shards=(1, 2, 4, 6, 6))
        if version == "0.4":
            options["chunk_key_encoding"] = {"name": "v2", "separator": "/"}
        made = root.create_array(str(level), shape=array_data.shape, dtype="uint16", **options)
        made[...] = array_data
    axes = [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"}]
    axes += [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    def scale(level):
        return [{"type": "scale", "scale": [1, 1, 2.0 * 2**level, 0.5 * 2**level, 0.25 * 2**level]},
                {"type": "translation", "translation": [0, 0, 1.0, 0.0, 0.0]}]
    multiscales = [{"axes": axes, "name": "image", "coordinateTransformations": [{"type": "scale", "scale": [0.1, 1, 1, 1, 2]}],
                    "datasets": [{"path": str(level), "coordinateTransformations": scale(level)} for level in range(2)]}]
    omero = {"channels": [{"window": {"start": 3, "end": 90, "min": 0, "max": 97}}, {"window": {"start": 103, "end": 190, "min": 0, "max": 197}}]}
    if version == "0.4":
        multiscales[0]["version"] = version
        root.attrs.update({"multiscales": multiscales, "omero": omero})
    else:
        root.attrs.update({"ome": {"version": version, "multiscales": multiscales, "omero": omero}})


def main():
    target = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        plain(folder)
        threes(folder)
        image(folder, "image4.ome.zarr", "0.4")
        image(folder, "image5.ome.zarr", "0.5")
        image(folder, "sharded5.ome.zarr", "0.5", sharded=True)
        files = {str(path.relative_to(folder)): path.read_bytes().hex() for path in sorted(folder.rglob("*")) if path.is_file()}
    lines = ",\n".join(f"{json.dumps(path)}: {json.dumps(content)}" for path, content in files.items())
    target.write_bytes(gzip.compress(("{\n" + lines + "\n}\n").encode(), 9, mtime=0))
    print(f"{len(files)} files, {target.stat().st_size} bytes")


main()

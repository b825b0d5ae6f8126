"""Checks slicecast's readers against SimpleITK, nibabel and pydicom: shape, spacing, orientation, unit, every voxel.

    python -m venv peers && peers/bin/pip install SimpleITK nibabel pydicom numpy
    peers/bin/python check_readers.py PATH/TO/slicecast DATA_FOLDER

Each volume found below DATA_FOLDER is read by `slicecast inspect --json` and by a peer, brought to LPS by the peer's own
means, and compared: sizes and the CRC-32 of all stored values exactly, spacing to 1 part in 100,000. Exits 1 if any
differ. Not part of the build; needs only what pip installs.
"""
import json, pathlib, subprocess, sys, zlib

import nibabel as nib
import numpy as np
import pydicom
import SimpleITK as sitk

TYPES = {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float": "f4", "double": "f8"}


def by_sitk(path):
    """Array (z, y, x) and spacing in LPS, read by SimpleITK."""
    image = sitk.ReadImage(str(path))
    if path.suffix in (".nhdr", ".nrrd", ".mhd", ".mha"):
        text = path.read_bytes()[:4096].decode("latin-1")
        if "space directions" not in text and "TransformMatrix" not in text:
            return sitk.GetArrayFromImage(image), image.GetSpacing()
    image = sitk.DICOMOrient(image, "LPS")
    return sitk.GetArrayFromImage(image), image.GetSpacing()


def by_nibabel(path):
    """The same by nibabel: closest canonical is RAS, so x and y are reversed."""
    image = nib.as_closest_canonical(nib.load(path))
    array = np.asanyarray(image.dataobj.get_unscaled() if hasattr(image.dataobj, "get_unscaled") else image.dataobj)
    return array[::-1, ::-1].transpose(2, 1, 0), image.header.get_zooms()


def by_pydicom(folder):
    """The same by pydicom: axial slices in order of their position."""
    slices = [pydicom.dcmread(p) for p in sorted(folder.iterdir())]
    row, column = np.split(np.array(slices[0].ImageOrientationPatient, float), 2)
    normal = np.cross(row, column)
    slices.sort(key=lambda s: np.dot(normal, np.array(s.ImagePositionPatient, float)))
    assert np.allclose(np.abs(np.stack([row, column, normal])), np.eye(3), atol=1e-6), "only axial series are compared"
    array = np.stack([s.pixel_array for s in slices])
    for axis, direction in zip((2, 1, 0), (row, column, normal)):
        if direction.sum() < 0:
            array = np.flip(array, axis)
    places = [np.dot(normal, np.array(s.ImagePositionPatient, float)) for s in slices]
    between_rows, between_columns = map(float, slices[0].PixelSpacing)
    return array, (between_columns, between_rows, abs(places[-1] - places[0]) / (len(places) - 1))


def sitk_series(folder):
    reader = sitk.ImageSeriesReader()
    names = max((reader.GetGDCMSeriesFileNames(str(folder), i) for i in reader.GetGDCMSeriesIDs(str(folder))), key=len)
    reader.SetFileNames(names)
    image = sitk.DICOMOrient(reader.Execute(), "LPS")
    return sitk.GetArrayFromImage(image), image.GetSpacing()


def compare(binary, path, peer, read, unit):
    found = json.loads(subprocess.run([binary, "inspect", "--json", str(path)], capture_output=True, check=True).stdout)
    array, spacing = read(path)
    faults = []
    if found["dims"] != list(array.shape[::-1]):
        faults.append(f"size {found['dims']} against {array.shape[::-1]}")
    if not np.allclose(found["spacing"], spacing, rtol=1e-5, atol=0):
        faults.append(f"spacing {found['spacing']} against {spacing}")
    stored = array.astype(np.float64)
    if unit:  # The peer has already applied slope and intercept.
        stored = (stored - found["value_offset"]) / found["value_scale"]
    crc = zlib.crc32(np.ascontiguousarray(stored.astype("<" + TYPES[found["value_type"]])).tobytes())
    if f"{crc:08x}" != found["crc32"]:
        faults.append(f"voxels {found['crc32']} against {crc:08x}")
    size = "x".join(map(str, found["dims"]))
    print(f"{path.name:28} {peer:10} {size:12} {found['orientation'][:28]:28} {found['crc32']}  {'; '.join(faults) or 'equal'}")
    return not faults


def main(binary, data):
    data, good = pathlib.Path(data), True
    for path in sorted(p for p in data.rglob("*") if p.suffix in (".nrrd", ".nhdr", ".mhd", ".mha") or p.name.endswith((".nii", ".nii.gz"))):
        if "frogtissue" in path.name:
            # ITK believes the header's CompressedDataSize, which is too small, and leaves the end of the volume undefined.
            read = lambda p: (np.frombuffer(zlib.decompress(p.with_suffix(".zraw").read_bytes()), "u1").reshape(136, 470, 500), (1, 1, 1.5))
            good &= compare(binary, path, "zlib", read, False)
        else:
            good &= compare(binary, path, "SimpleITK", by_sitk, path.name.endswith((".nii", ".nii.gz")))
        if path.name.endswith((".nii", ".nii.gz")):
            good &= compare(binary, path, "nibabel", by_nibabel, False)
    for folder in sorted({p.parent for p in data.rglob("*.dcm")}):
        good &= compare(binary, folder, "pydicom", by_pydicom, False)
        good &= compare(binary, folder, "SimpleITK", sitk_series, True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))

"""Writes small sound files of every format as seeds for the fuzz targets.

    python seeds.py OUT        with SimpleITK, nibabel, numpy, pillow, pydicom and pyjpegls installed

OUT/<target>/ can be given to `cargo fuzz run <target>` as a further corpus folder.
"""
import gzip, io, pathlib, struct, sys, zlib
import nibabel as nib, numpy as np, pydicom
from pydicom.dataset import FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import (DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian,
                         JPEG2000Lossless, JPEGBaseline8Bit, JPEGLSLossless, RLELossless)
from PIL import Image
import SimpleITK as sitk

out = pathlib.Path(sys.argv[1])
here = pathlib.Path(__file__).parent
values = np.arange(60, dtype=np.int16).reshape(5, 4, 3) * 7 - 100


def put(target, name, data):
    (out / target).mkdir(parents=True, exist_ok=True)
    (out / target / name).write_bytes(data if isinstance(data, bytes) else data.encode())


# NRRD
head = ("NRRD0005\n# seed\ntype: short\ndimension: 3\nsizes: 3 4 5\nspace: right-anterior-superior\n"
        "space directions: (0,0.5,0) (0,0,-2) (3,0,0)\nendian: little\nhounsfield_offset:=-1024\nmodality:=CT\n")
plain = values.tobytes()
import bz2
put("nrrd", "raw", (head + "encoding: raw\nbyte skip: 2\n\n").encode() + b"ab" + plain)
put("nrrd", "gzip", (head + "encoding: gzip\nline skip: 1\n\n").encode() + b"x\n" + gzip.compress(plain))
put("nrrd", "bzip2", (head + "encoding: bzip2\n\n").encode() + bz2.compress(plain))
put("nrrd", "ascii", head + "encoding: ascii\n\n" + " ".join(map(str, values.ravel())) + "\n")
units = head.replace("space directions", 'space units: "cm" "mm" "um"\nspace directions')
put("nrrd", "units", (units + "encoding: raw\n\n").encode() + plain)
put("nrrd", "four-axes", head.replace("dimension: 3", "dimension: 4").replace("sizes: 3 4 5", "sizes: 1 3 4 5")
    .replace("directions: ", "directions: none ").encode() + b"encoding: raw\n\n" + plain)
put("nrrd", "long", b"NRRD0004\ntype: int64\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 1\nendian: big\nencoding: raw\n\n" + struct.pack(">2q", -5, 2**40))

# NIfTI
for kind, cls in (("1", nib.Nifti1Image), ("2", nib.Nifti2Image)):
    for dtype in (np.int16, np.float32):
        image = cls(values.transpose(2, 1, 0).astype(dtype), np.diag([-2, 2, 3, 1.0]))
        image.header.set_slope_inter(0.5, -3)
        raw = image.to_bytes()
        put("nifti", f"n{kind}-{np.dtype(dtype).name}", raw)
        put("nifti", f"n{kind}-{np.dtype(dtype).name}.gz", gzip.compress(raw))
    image.set_qform(np.array([[0, 0, 2, 1], [1, 0, 0, 1], [0, 1.5, 0, 1], [0, 0, 0, 1.0]]), 1)
    image.set_sform(None, 0)
    put("nifti", f"n{kind}-qform", image.to_bytes())

# MetaImage
meta = ("ObjectType = Image\nNDims = 3\nBinaryData = {b}\nBinaryDataByteOrderMSB = {m}\nCompressedData = {c}\n"
        "TransformMatrix = 0 1 0 0 0 -1 1 0 0\nElementSpacing = 1 2 3\nDimSize = 3 4 5\nElementType = MET_SHORT\nElementDataFile = LOCAL\n")
put("metaimage", "raw", meta.format(b=True, m=False, c=False).encode() + plain)
put("metaimage", "msb", meta.format(b=True, m=True, c=False).encode() + values.astype(">i2").tobytes())
put("metaimage", "zlib", meta.format(b=True, m=False, c=True).encode() + zlib.compress(plain))
put("metaimage", "units", ("DistanceUnits = um\n" + meta.format(b=True, m=False, c=False)).encode() + plain)
put("metaimage", "text", meta.format(b=False, m=False, c=False) + " ".join(map(str, values.ravel())))

# TIFF
import tempfile
for dtype, compress in ((np.uint8, False), (np.uint16, True), (np.float32, False), (np.int16, False)):
    with tempfile.NamedTemporaryFile(suffix=".tif") as f:
        image = sitk.GetImageFromArray(values.astype(dtype))
        writer = sitk.ImageFileWriter()
        writer.SetFileName(f.name)
        writer.SetUseCompression(compress)
        writer.SetCompressor("Deflate" if compress else "")
        writer.Execute(image)
        put("tiff", np.dtype(dtype).name, pathlib.Path(f.name).read_bytes())

pages = [Image.fromarray(page.astype(np.uint8)) for page in values]
ome = ("<OME><Image><Pixels DimensionOrder='XYZCT' Type='uint8' SizeX='3' SizeY='4' SizeZ='5' SizeC='1' SizeT='1' PhysicalSizeX='0.5'"
       " PhysicalSizeY='0.5' PhysicalSizeZ='2' PhysicalSizeZUnit='nm'><TiffData IFD='0' PlaneCount='5'/></Pixels></Image></OME>")
for name, description, count in (
    ("imagej", "ImageJ=1.54f\nimages=5\nslices=5\nspacing=2\nunit=\\u00B5m\n", 5),
    ("imagej-channels", "ImageJ=1.54f\nimages=4\nchannels=2\nslices=2\nhyperstack=true\nspacing=2\nunit=mm\ncf=0\nc0=-32768\nc1=1\n", 4),
    ("imagej-one-directory", "ImageJ=1.54f\nimages=5\nslices=5\n", 1),
    ("ome", ome, 5),
    ("tifffile", '{"shape": [5, 4, 3]}', 5),
):
    out_file = io.BytesIO()
    pages[0].save(out_file, "TIFF", save_all=True, append_images=pages[1:count], tiffinfo={270: description})
    put("tiff", name, out_file.getvalue() + (b"".join(page.tobytes() for page in pages[1:]) if count == 1 else b""))

# DICOM
COMPRESSED = (RLELossless, JPEGLSLossless)


def slice_file(i, syntax, nested=False):
    meta = FileMetaDataset()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian if syntax in COMPRESSED else syntax
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    meta.MediaStorageSOPInstanceUID = f"1.2.3.{i + 1}"
    ds = pydicom.Dataset()
    ds.file_meta = meta
    ds.SOPClassUID, ds.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    ds.Modality, ds.SeriesInstanceUID, ds.SeriesNumber = "CT", "1.2.3", 1
    ds.ImagePositionPatient, ds.ImageOrientationPatient = [0, 0, 2.5 * i], [1, 0, 0, 0, 1, 0]
    ds.PixelSpacing, ds.SliceThickness = [0.5, 0.75], 2.5
    # pyjpegls has no room for the header of smaller images.
    pixels = np.tile(values[i], (4, 4)) if syntax in COMPRESSED else values[i]
    (ds.Rows, ds.Columns), ds.SamplesPerPixel, ds.PhotometricInterpretation = pixels.shape, 1, "MONOCHROME2"
    ds.BitsAllocated, ds.BitsStored, ds.HighBit, ds.PixelRepresentation = 16, 16, 15, 1
    ds.RescaleSlope, ds.RescaleIntercept = 1, -1024
    ds.WindowCenter, ds.WindowWidth = 40, 400
    if nested:
        inner = pydicom.Dataset()
        inner.CodeValue = "x"
        outer = pydicom.Dataset()
        outer.ContentSequence = [inner]
        ds.ReferencedStudySequence = [outer]
        ds["ReferencedStudySequence"].is_undefined_length = True
        ds.ReferencedStudySequence[0].is_undefined_length_sequence_item = True
    ds.PixelData = pixels.tobytes()
    if syntax in COMPRESSED:
        ds.PixelRepresentation = 0
        ds.compress(syntax)
    if syntax in (JPEGBaseline8Bit, JPEG2000Lossless):
        ds.BitsAllocated, ds.BitsStored, ds.HighBit, ds.PixelRepresentation = 8, 8, 7, 0
        frame = io.BytesIO()
        if syntax == JPEGBaseline8Bit:
            pages[i].save(frame, "JPEG")
        else:
            pages[i].save(frame, "JPEG2000", no_jp2=True, num_resolutions=2)
        ds.PixelData = encapsulate([frame.getvalue()])
        ds["PixelData"].is_undefined_length = True
    if syntax == ExplicitVRBigEndian:
        ds.PixelData = values[i].astype(">i2").tobytes()
    return written(ds)


def written(ds):
    f = io.BytesIO()
    pydicom.dcmwrite(f, ds, enforce_file_format=True)
    return f.getvalue()


def of_frames():
    """An enhanced image of three frames."""
    ds = pydicom.dcmread(io.BytesIO(slice_file(0, ExplicitVRLittleEndian)))
    groups = []
    for i in range(3):
        place, group = pydicom.Dataset(), pydicom.Dataset()
        place.ImagePositionPatient = [0, 0, 2.5 * i]
        group.PlanePositionSequence = [place]
        groups.append(group)
    measures, turn, shared = pydicom.Dataset(), pydicom.Dataset(), pydicom.Dataset()
    measures.PixelSpacing, measures.SliceThickness = [0.5, 0.75], 2.5
    turn.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    shared.PixelMeasuresSequence, shared.PlaneOrientationSequence = [measures], [turn]
    del ds.ImagePositionPatient, ds.ImageOrientationPatient, ds.PixelSpacing
    ds.NumberOfFrames, ds.PerFrameFunctionalGroupsSequence, ds.SharedFunctionalGroupsSequence = 3, groups, [shared]
    ds.PixelData = values[:3].tobytes()
    return written(ds)


def of_phases():
    """Two times of two slices."""
    files = []
    for i in range(4):
        ds = pydicom.dcmread(io.BytesIO(slice_file(i // 2, ExplicitVRLittleEndian)))
        ds.TemporalPositionIdentifier, ds.SOPInstanceUID, ds.InstanceNumber = i % 2 + 1, f"1.2.3.4.{i}", i + 1
        files.append(written(ds))
    return b"<next>".join(files)


for name, syntax in (("explicit", ExplicitVRLittleEndian), ("implicit", ImplicitVRLittleEndian),
                     ("deflated", DeflatedExplicitVRLittleEndian), ("big", ExplicitVRBigEndian), ("rle", RLELossless),
                     ("jpeg", JPEGBaseline8Bit), ("jpeg-ls", JPEGLSLossless), ("jpeg-2000", JPEG2000Lossless)):
    put("dicom", name, b"<next>".join(slice_file(i, syntax, True) for i in (1, 0, 2)))
put("dicom", "single", slice_file(0, ExplicitVRLittleEndian))
put("dicom", "frames", of_frames())
put("dicom", "phases", of_phases())

# Texts
put("raw", "words", "4x5x6,uint16,big,spacing=1x1x2,skip=16,scale=2,offset=-1024,modality=CT,axes=RAS")
put("raw", "sidecar", "size = [4, 5, 6]\ntype = 'uint16'\nendian = 'big'\nspacing = [1, 1, 2]\nskip = 1\nscale = 1\noffset = 0\nmodality = 'CT'\naxes = 'RAS'\n")
put("raw", "name", "bonsai_256x256x256_uint8.raw")
for scene in (here.parent / "scene" / "scenes").glob("*.toml"):
    put("scene", scene.name, scene.read_bytes())
put("transfer", "vp", "1\n1\n0.9\n0.1\n0.2\n10\n6 -3024 0 10 0.5 3071 0.6\n4 0 1 255 1\n12 -3024 0 0 0 10 1 0 0 3071 1 1 1\n")
put("transfer", "vpjson", '{"@schema":"x","volumeProperties":[{"effectiveRange":[0,9],"components":[{"shade":true,"lighting":{"diffuse":1,"ambient":0.2,"specular":0,"specularPower":1},'
    '"scalarOpacityUnitDistance":2,"scalarOpacity":{"points":[{"x":0,"y":0,"midpoint":0.5,"sharpness":0},{"x":9,"y":1,"midpoint":0.3,"sharpness":0}]},'
    '"rgbTransferFunction":{"points":[{"x":0,"color":[0,0,0]},{"x":9,"color":[1,1,1]}]}}]}]}')
put("transfer", "paraview", '[{"ColorSpace":"Diverging","Name":"p","NanColor":[1,1,0],"RGBPoints":[0,0,0,0,9,1,1,1],"Points":[0,0,0.5,0,9,1,0.5,0]}]')

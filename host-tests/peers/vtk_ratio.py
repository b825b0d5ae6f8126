"""Times slicecast against VTK's vtkFixedPointVolumeRayCastMapper on the same volumes, rays, step, lights and threads.

    python3 -m venv peers && peers/bin/pip install vtk numpy
    peers/bin/python vtk_ratio.py PATH/TO/slicecast PATH/TO/bone-ct.nrrd [--frames 3] [--rounds 4]
                                  [--threads N] [--only fog|bone|colours] [--pictures DIR] [--perspective]

Three scenes, all under one white light from the viewer: dense fog (made here, 256^3, nothing can be skipped), and of a CT volume
its bone and, in many colours, all of it; the volume is made cubic first (linear along z), because rays are so many a voxel here and
so many a millimetre there.
Rays are half a voxel apart (512 x 512 over a face of 256 x 256 voxels), the step is that of slicecast's
sample planes, the view is parallel, the opacity table is corrected for the step by both, and a ray ends where less than
1/128 of its light is left (VTK: 255 of 32767). Rounds of VTK and of slicecast
take turns; the shortest frame of each counts. VTK's time is the mapper's own (GetTimeToDraw: its gradients are made
before the first frame and not counted, nor is showing the picture); slicecast's is all sample planes and the final warp,
`compact` and `fast`, all threads, in turns. With --perspective both see the scene from an eye, 40 degrees from the top of the picture to
its bottom, the whole volume within, in a picture of the same size, by `compact` on one thread each; slicecast's time is that of the whole
picture (`bench`, the ways to a picture: its pixels are mixed from up to five base planes). VTK's step is the same along all rays,
slicecast's grows to the side. With --pictures all pictures are written, to be looked at. Not part of the build.
"""
import argparse, json, math, os, pathlib, subprocess, tempfile, time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

VIEW = (17.0, 12.0)  # azimuth, elevation, degrees
FOV = 40.0  # that of the bench

SCENE = """[view]
azimuth = {view[0]}
elevation = {view[1]}
[sampling]
planes_per_voxel = 1
rays_per_voxel = 2
[transfer]
unit_distance = 1.0
points = [{points}]
[render]
early_termination = 7
[lighting]
ambient = 0.2
diffuse = 0.7
specular = 0.2
exponent = 32
[[lighting.lights]]
direction = [0.0, 0.0, 1.0]
"""


def fog_points(side):
    thin = 2.3 / side
    return [(0.0, "#ffffff", 0.5 * thin), (4095.0, "#ffffff", 1.5 * thin)]


BONE = [(200.0, "#f2e8d0", 0.0), (400.0, "#f2e8d0", 0.7)]
COLOURS = [
    (-600.0, "#402018", 0.0), (-300.0, "#d09070", 0.02), (0.0, "#e0b040", 0.02), (60.0, "#c03028", 0.04),
    (160.0, "#8040a0", 0.03), (300.0, "#f0e0c0", 0.2), (1200.0, "#ffffff", 0.6),
]
PRECISIONS = ["compact", "fast"]


def write(path, voxels, spacing):
    """Voxels (z, y, x) of 16 bits, cubic, as NRRD."""
    sizes = " ".join(map(str, voxels.shape[::-1]))
    kind = {"u": "ushort", "i": "short"}[voxels.dtype.kind]
    header = f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nspacings: {spacing} {spacing} {spacing}\nendian: little\nencoding: raw\n\n"
    path.write_bytes(header.encode() + voxels.astype(voxels.dtype.newbyteorder("<")).tobytes())


def fog(side=256):
    z, y, x = np.mgrid[0:side, 0:side, 0:side]
    return (2048 + 590 * (np.sin(x / 7.5) + np.sin(y / 9.7) + np.sin(z / 5.9))).astype(np.uint16)


def cubic(path):
    """A volume with slices as far apart as its voxels, and that distance."""
    reader = vtk.vtkNrrdReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    nx, ny, nz = image.GetDimensions()
    voxels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(nz, ny, nx).astype(np.float32)
    across, _, along = image.GetSpacing()
    place = np.arange(0, (nz - 1) * along, across) / along
    before = np.minimum(place.astype(int), nz - 2)
    share = (place - before)[:, None, None]
    return np.rint(voxels[before] * (1 - share) + voxels[before + 1] * share).astype(np.int16), across


def to_vtk(voxels, spacing):
    image = vtk.vtkImageData()
    image.SetDimensions(*voxels.shape[::-1])
    image.SetSpacing(spacing, spacing, spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(voxels.ravel(), deep=True))
    return image


class Vtk:
    """A scene in VTK."""

    def __init__(self, image, points, threads, perspective):
        sides = [(n - 1) * s for n, s in zip(image.GetDimensions(), image.GetSpacing())]
        azimuth, elevation = map(math.radians, VIEW)
        (sa, ca), (se, ce) = ((math.sin(a), math.cos(a)) for a in (azimuth, elevation))
        forward, up, right = (-sa * ce, ca * ce, -se), (-sa * se, ca * se, ce), (ca, sa, 0.0)
        reach = lambda axis: sum(abs(a) * side for a, side in zip(axis, sides))
        pixel = min(image.GetSpacing()) / 2
        size = [math.ceil(reach(axis) / pixel) + 1 for axis in (right, up)]

        colours, opacities = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
        for value, colour, opacity in points:
            colours.AddRGBPoint(value, *(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)))
            opacities.AddPoint(value, opacity)
        look = vtk.vtkVolumeProperty()
        look.SetColor(colours)
        look.SetScalarOpacity(opacities)
        look.SetScalarOpacityUnitDistance(1.0)
        look.SetInterpolationTypeToLinear()
        look.ShadeOn()
        look.SetAmbient(0.2), look.SetDiffuse(0.7), look.SetSpecular(0.2), look.SetSpecularPower(32.0)

        self.mapper = vtk.vtkFixedPointVolumeRayCastMapper()
        self.mapper.SetInputData(image)
        self.mapper.SetAutoAdjustSampleDistances(0)
        self.mapper.SetImageSampleDistance(1.0)
        # A sample plane per voxel along y, which the view is nearest to.
        self.mapper.SetSampleDistance(min(s / abs(f) for s, f in zip(image.GetSpacing(), forward)))
        self.mapper.SetInteractiveSampleDistance(self.mapper.GetSampleDistance())
        self.mapper.IntermixIntersectingGeometryOff()
        self.mapper.SetNumberOfThreads(threads)
        volume = vtk.vtkVolume()
        volume.SetMapper(self.mapper)
        volume.SetProperty(look)
        renderer = vtk.vtkRenderer()
        renderer.AddVolume(volume)
        renderer.TwoSidedLightingOff()  # What faces away from a light is dark in slicecast.
        light = vtk.vtkLight()
        light.SetLightTypeToHeadlight()
        light.SetAmbientColor(1, 1, 1)  # VTK's lights have no ambient part unless they are told.
        renderer.AddLight(light)
        camera = renderer.GetActiveCamera()
        centre = [side / 2 for side in sides]
        camera.SetFocalPoint(*centre)
        far = 1000
        if perspective:
            camera.SetViewAngle(FOV)
            diagonal = math.dist([0] * 3, [n * s for n, s in zip(image.GetDimensions(), image.GetSpacing())])
            far = diagonal / 2 / math.sin(math.radians(FOV / 2))
        else:
            camera.ParallelProjectionOn()
        camera.SetPosition(*(c - far * f for c, f in zip(centre, forward)))
        camera.SetViewUp(*up)
        camera.SetParallelScale(size[1] * pixel / 2)
        renderer.ResetCameraClippingRange()
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetSize(*size)
        self.window.AddRenderer(renderer)
        self.size, self.volume = size, volume
        start = time.perf_counter()
        self.window.Render()
        self.first = time.perf_counter() - start

    def frame(self):
        self.volume.Modified()
        start = time.perf_counter()
        self.window.Render()
        whole = time.perf_counter() - start
        return min(self.mapper.GetTimeToDraw(), whole)

    def picture(self, path):
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(str(path))
        writer.SetInputConnection(grab.GetOutputPort())
        writer.Write()
        return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(self.size[1], self.size[0], -1)


def slicecast(binary, volume, scene, frames, threads, folder, perspective):
    """The scene's shortest frame of each precision, seconds, and its samples."""
    report = folder / "bench.json"
    command = [binary, "bench", volume, "--scene", scene, "--sides", "0", "--frames", frames, "--threads", threads, "--json", report, "--force"]
    subprocess.run(list(map(str, command)), check=True, capture_output=True)
    section = json.loads(report.read_text())["sections"][0]
    if perspective:
        way = next(way for way in section["ways"] if way["way"] == "rays, in perspective")
        return [way["milliseconds"] / 1e3], way["count"]
    # The last row is on all threads.
    rows = [[row for row in section["rows"] if row["engine"] == precision][-1] for precision in PRECISIONS]
    return [(row["milliseconds"] + section["beside"]["warp_milliseconds"]) / 1e3 for row in rows], section["samples"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary")
    parser.add_argument("ct")
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--only", choices=["fog", "bone", "colours"])
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("--perspective", action="store_true")
    asked = parser.parse_args()
    threads = 1 if asked.perspective else asked.threads or os.cpu_count()
    precisions = PRECISIONS[:1] if asked.perspective else PRECISIONS
    print(f"VTK {vtk.vtkVersion().GetVTKVersion()}, {threads} threads, shortest of {asked.rounds} x {asked.frames} frames")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        ct = cubic(asked.ct)
        scenes = [("dense fog", fog(), 1.0, fog_points(256)), ("bone CT", *ct, BONE), ("colours CT", *ct, COLOURS)]
        for name, voxels, spacing, points in scenes:
            if asked.only and asked.only not in name:
                continue
            path = folder / f"{name.split()[0]}.nrrd"
            write(path, voxels, spacing)
            listed = ", ".join(f'{{ value = {v}, colour = "{c}", opacity = {o} }}' for v, c, o in points)
            scene = folder / f"{name.split()[0]}.toml"
            scene.write_text(SCENE.format(view=VIEW, points=listed))
            peer = Vtk(to_vtk(voxels, spacing), points, threads, asked.perspective)
            ours, theirs = [math.inf] * len(precisions), math.inf
            for _ in range(asked.rounds):
                theirs = min([theirs] + [peer.frame() for _ in range(asked.frames)])
                seconds, samples = slicecast(asked.binary, path, scene, asked.frames, threads, folder, asked.perspective)
                ours = list(map(min, ours, seconds))
            kind = "lit, in perspective" if asked.perspective else "lit"
            print(
                f"{name}, {kind}, {peer.size[0]} x {peer.size[1]} rays, {samples / 1e6:.1f} M samples: VTK {1e3 * theirs:.1f} ms "
                f"(first frame {peer.first:.2f} s)"
                + "".join(f", {own} {1e3 * took:.1f} ms: {theirs / took:.1f} times as fast" for own, took in zip(precisions, ours))
            )
            if asked.pictures:
                asked.pictures.mkdir(parents=True, exist_ok=True)
                stem = name.replace(" ", "-")
                theirs_picture = peer.picture(asked.pictures / f"{stem}-vtk.png")
                size = f"{peer.size[0]}x{peer.size[1]}"
                seen = ["--fov", str(FOV)] if asked.perspective else []
                for precision in precisions:
                    own = asked.pictures / f"{stem}-{precision}.png"
                    command = [asked.binary, "render", path, "--scene", scene, "--precision", precision]
                    command += ["--size", size, "-o", own, "--force"] + seen
                    subprocess.run(list(map(str, command)), check=True, capture_output=True)
                    reader = vtk.vtkPNGReader()
                    reader.SetFileName(str(own))
                    reader.Update()
                    mine = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(*theirs_picture.shape[:2], -1)
                    difference = np.abs(mine[..., :3].astype(int) - theirs_picture[..., :3].astype(int))
                    most = np.percentile(difference, 99)
                    print(f"  pictures of {precision}: mean difference {difference.mean():.2f} of 255, 99 % below {most:.0f}")


if __name__ == "__main__":
    main()

"""Times slicecast against VTK's vtkFixedPointVolumeRayCastMapper on the same volumes, rays, step, lights and threads.

    python3 -m venv peers && peers/bin/pip install vtk numpy
    peers/bin/python vtk_ratio.py PATH/TO/slicecast PATH/TO/bone-ct.nrrd [--frames 3] [--rounds 4]
                                  [--threads N] [--only fog|bone] [--pictures DIR] [--perspective]

Two scenes, both under one white light from the viewer: dense fog (made here, 256^3, nothing can be skipped) and the bone
of a CT volume, made cubic first (linear along z), because rays are so many a voxel here and so many a millimetre there.
Rays are half a voxel apart (512 x 512 over a face of 256 x 256 voxels), the step is that of slicecast's
sample planes, the view is parallel, the opacity table is corrected for the step by both, and a ray ends where less than
1/128 of its light is left (VTK: 255 of 32767). Rounds of VTK and of slicecast
take turns; the shortest frame of each counts. VTK's time is the mapper's own (GetTimeToDraw: its gradients are made
before the first frame and not counted, nor is showing the picture); slicecast's is all sample planes and the final warp,
`compact`, all threads. With --perspective both see the scene from an eye, 40 degrees from the top of the picture to its bottom, the whole
volume within, in a picture of the same size; one thread each, and slicecast's time is that of the whole picture (`bench`, the ways to a
picture: its pixels are mixed from up to five base planes). VTK's step is the same along all rays, slicecast's grows to the side. With --pictures both pictures are written, to be looked at. Not part of the build.
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
    """The scene's shortest frame, seconds, and its samples."""
    report = folder / "bench.json"
    command = [binary, "bench", volume, "--scene", scene, "--sides", "0", "--frames", frames, "--threads", threads, "--json", report, "--force"]
    subprocess.run(list(map(str, command)), check=True, capture_output=True)
    section = json.loads(report.read_text())["sections"][0]
    if perspective:
        way = next(way for way in section["ways"] if way["way"] == "rays, in perspective")
        return way["milliseconds"] / 1e3, way["count"]
    row = [row for row in section["rows"] if row["engine"] == "compact"][-1]  # The last one is on all threads.
    return (row["milliseconds"] + section["beside"]["warp_milliseconds"]) / 1e3, section["samples"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary")
    parser.add_argument("ct")
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--only", choices=["fog", "bone"])
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("--perspective", action="store_true")
    asked = parser.parse_args()
    threads = 1 if asked.perspective else asked.threads or os.cpu_count()
    print(f"VTK {vtk.vtkVersion().GetVTKVersion()}, {threads} threads, shortest of {asked.rounds} x {asked.frames} frames")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        scenes = [("dense fog", fog(), 1.0, fog_points(256), 8), ("bone CT", *cubic(asked.ct), BONE, 4)]
        for name, voxels, spacing, points, aim in scenes:
            if asked.only and asked.only not in name:
                continue
            path = folder / f"{name.split()[0]}.nrrd"
            write(path, voxels, spacing)
            listed = ", ".join(f'{{ value = {v}, colour = "{c}", opacity = {o} }}' for v, c, o in points)
            scene = folder / f"{name.split()[0]}.toml"
            scene.write_text(SCENE.format(view=VIEW, points=listed))
            peer = Vtk(to_vtk(voxels, spacing), points, threads, asked.perspective)
            ours, theirs = math.inf, math.inf
            for _ in range(asked.rounds):
                theirs = min([theirs] + [peer.frame() for _ in range(asked.frames)])
                seconds, samples = slicecast(asked.binary, path, scene, asked.frames, threads, folder, asked.perspective)
                ours = min(ours, seconds)
            print(
                f"{name}, lit, {'in perspective, ' if asked.perspective else ''}{peer.size[0]} x {peer.size[1]} rays, {samples / 1e6:.1f} M samples: VTK {1e3 * theirs:.1f} ms "
                f"(first frame {peer.first:.2f} s), slicecast {1e3 * ours:.1f} ms: {theirs / ours:.1f} times as fast (aim {aim})"
            )
            if asked.pictures:
                asked.pictures.mkdir(parents=True, exist_ok=True)
                stem = name.replace(" ", "-")
                theirs_picture = peer.picture(asked.pictures / f"{stem}-vtk.png")
                own = asked.pictures / f"{stem}-slicecast.png"
                size = f"{peer.size[0]}x{peer.size[1]}"
                seen = ["--fov", str(FOV)] if asked.perspective else []
                subprocess.run([asked.binary, "render", str(path), "--scene", str(scene), "--size", size, "-o", str(own), "--force"] + seen, check=True, capture_output=True)
                reader = vtk.vtkPNGReader()
                reader.SetFileName(str(own))
                reader.Update()
                mine = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(theirs_picture.shape[0], theirs_picture.shape[1], -1)
                difference = np.abs(mine[..., :3].astype(int) - theirs_picture[..., :3].astype(int))
                print(f"  pictures: mean difference {difference.mean():.2f} of 255, 99 % below {np.percentile(difference, 99):.0f}")


if __name__ == "__main__":
    main()

"""Reads data sets of ensonify. Copy this folder beside your own code.

    from ensonify_dataset import SonarDataset, normalise
    data = SonarDataset("out/random_debris")
    ping = data.split("train")[0]                # or data[12, 3]: sequence 12, ping 3
    picture = normalise(ping.polar.level_db)     # float32 [samples, beams]
    mask = ping.polar.instance                   # int32 [samples, beams], 0: none

Python 3.9 and NumPy, nothing else. Nothing is read before it is asked for; time series are
memory-mapped. For PyTorch there is `ensonify_dataset.pytorch.TorchPings`.
What the numbers mean: docs/dataset.md and docs/conventions.md; examples: docs/training.md.

    dataset.py     SonarDataset, SequenceFolder, Ping, Pose
    views.py       View, Annotation
    front.py       FrontView
    camera.py      Camera, CameraImage: `ping.camera`, and pixels of the sonar and of the camera
    elevation.py   ElevationEchoes: echo power over elevation, and what beams and pulse make of it
    projection.py  project, unproject, flow_to_image
    sweep.py       SonarSweep: the runs of a sweep, by the values that vary
    scene.py       Track, HeightMap: of a sequence, `data.sequence(0).tracks()`
    navigation.py  tables of navigation sensors, `data.sequence(0).navigation`
    manifest.py    what manifests and tables list, checked
    files.py       read_png, read_exr, decode_rle, DatasetError
    statistics.py  Statistics, Estimate, Histogram: of speckle studies, `data.sequence(0).statistics`
    merging.py     merge: of realizations of one scene; Worlds: of several worlds of one scenario
    recorded.py    the counts of a recorder, and their levels
    footprints.py  what Cartesian 8-bit images are made of
    transforms.py  Display, to_db, to_grey, to_amplitude, normalise
    viewer.py      Viewer, redrawn: display gain, lost beams, JPEG and pixels, after the recorder
    pytorch.py     TorchPings; the only one that imports torch
"""
from .camera import Camera, CameraImage, SonarPlace
from .dataset import Ping, Pose, SequenceFolder, SonarDataset
from .elevation import ElevationEchoes
from .files import DatasetError, decode_rle, read_exr, read_png
from .front import FrontView
from .merging import Variances, Worlds, merge
from .projection import Projected, flow_to_image, project, unproject
from .scene import HeightMap, Track
from .statistics import Estimate, Histogram, Statistics
from .sweep import SonarSweep, SweepRun
from .transforms import NO_ENERGY_DB, Display, normalise, to_amplitude, to_db, to_grey
from .viewer import Viewer, redrawn
from .views import Annotation, View

__all__ = [
    "Annotation", "Camera", "CameraImage", "DatasetError", "Display", "ElevationEchoes", "Estimate", "FrontView", "HeightMap",
    "Histogram", "NO_ENERGY_DB", "Ping", "Pose", "Projected", "SequenceFolder", "SonarDataset", "SonarPlace", "SonarSweep",
    "Statistics", "SweepRun", "Track", "Variances", "View", "Viewer", "Worlds", "decode_rle", "flow_to_image", "merge",
    "normalise", "project", "read_exr", "read_png", "redrawn", "to_amplitude", "to_db", "to_grey", "unproject",
]

"""A tiny tank data set, ray by ray from closed forms, for the self-test of the checks.

Two sequences of the same tank, 128 beams, 9 rays in elevation, one ping: plain, and with noise. Or
one, "burst", with all that these leave out: a burst through a window, a shaded array, a transmit
pattern, a converter, a rician cylinder and noise by ratio.
Written after the documented layout with this folder's own formulas and writers.
"""
import dataclasses
import hashlib
import json
import os

import numpy as np

import labels
import physics
import random_numbers
from beam_patterns import Shading, aperture_wavelengths
from boxes import BOXES_HEADER
from check_scatterers import FIELDS
from pulses import Pulse
from sequence import Adc, Grid, Sonar
from surface_laws import rician_share
from synthetic_coco import annotation_line, coco_of
from synthetic_files import exr_bytes, png_bytes

SEED = 11
NOISE_LEVEL_DB = 60.0
MATERIALS = {1: 1e-3, 2: 1e-3}
CLASSES = ["structure", "cylinder"]
NAMES = {1: "tank", 2: "target"}
TANK_HALF_M = np.array([5.5, 5.5, 2.0])
AXIS_M, RADIUS_M = 4.0, 0.2
BOX = {"size_m": [99.0] * 3, "centre_m": [0.0] * 3, "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]}
POSE = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
CARTESIAN_HEIGHT = 58  # few pixels have their center on a border
RICIAN_K = 0.5


def make_sonar(noise_level_db, **more):
    """The common sonar; more replaces or adds fields."""
    plain = Sonar(
        beams=128,
        spacing_rad=np.radians(90) / 128,
        width_rad=np.radians(1.0),
        elevation_width_rad=np.radians(20.0),
        fan_rad=np.radians(20.0),
        rays_elevation=9,
        rays_azimuth=1,
        frequency_hz=9e5,
        bandwidth_hz=29900.0,
        source_pressure_pa_m=physics.source_pressure_pa_m(220.0),
        range_min_m=0.0,
        range_max_m=10.0,
        sound_speed_m_s=1500.0,
        absorption_db_m=0.3,
        pulse=Pulse(),
        normalization="calibrated",
        noise_level_db=noise_level_db,
    )
    return dataclasses.replace(plain, **more)


def sonar_of(kind):
    """The sonar of a plain, noisy or burst sequence."""
    if kind != "burst":
        return make_sonar(NOISE_LEVEL_DB if kind == "noisy" else None)
    adc = Adc(16, 170.0, 10**2.5 / 2**15)
    return make_sonar(
        None,
        pulse=Pulse("cw", 2e-4, window="hann"),
        shading=Shading("taylor"),
        elevation_shading=Shading("hann"),
        transmit_width_rad=np.radians(80.0),
        adc=adc,
        snr_db=30.0,
    )


def coherent_part(kind, identity):
    return {"model": "rician", "k": RICIAN_K} if (kind, identity) == ("burst", 2) else None


def trace(sonar):
    """Range, cosine of incidence and instance for rays [beams, elevations] from the origin."""
    step = sonar.fan_rad / sonar.rays_elevation
    elevation = (np.arange(sonar.rays_elevation) + 0.5) * step - sonar.fan_rad / 2
    azimuth, elevation = np.meshgrid(sonar.azimuths_rad, elevation, indexing="ij")
    direction = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=-1,
    )
    to_wall = TANK_HALF_M / np.maximum(np.abs(direction), 1e-12)
    range_m, cosine = (
        to_wall.min(axis=-1),
        np.take_along_axis(np.abs(direction), to_wall.argmin(axis=-1)[..., None], axis=-1)[..., 0],
    )
    inside = RADIUS_M**2 - (AXIS_M * np.sin(azimuth)) ** 2
    flat = AXIS_M * np.cos(azimuth) - np.sqrt(np.maximum(inside, 0))
    struck = inside > 0
    normal_x, normal_y = (AXIS_M - flat * np.cos(azimuth)) / RADIUS_M, -flat * np.sin(
        azimuth
    ) / RADIUS_M
    range_m = np.where(struck, flat / np.cos(elevation), range_m)
    cosine = np.where(struck, direction[..., 0] * normal_x + direction[..., 1] * normal_y, cosine)
    return range_m, cosine, np.where(struck, 2, 1), azimuth, elevation, direction


def make_scatterers(sonar, sequence, kind):
    """The scatterer list of ping 0, sorted by beam and delay."""
    range_m, cosine, instance, azimuth, elevation, direction = trace(sonar)
    step = sonar.fan_rad / sonar.rays_elevation
    solid_angle = sonar.spacing_rad * (np.sin(elevation + step / 2) - np.sin(elevation - step / 2))
    rays = np.arange(range_m.size).reshape(range_m.shape)
    out = np.zeros(range_m.shape, list(FIELDS))
    out["delay_s"] = 2 * range_m / sonar.sound_speed_m_s
    out["beam"] = np.arange(sonar.beams)[:, None]
    out["azimuth_rad"], out["elevation_rad"] = azimuth, elevation
    out["variance"] = np.vectorize(MATERIALS.get)(instance) * cosine * range_m**2 * solid_angle
    key = random_numbers.stream_key(SEED, random_numbers.STREAM_SPECKLE, sequence)
    for identity in MATERIALS:
        mine, coherent = instance == identity, coherent_part(kind, identity)
        share = rician_share(coherent)
        out["mean_re"][mine] = np.sqrt((1.0 - share) * out["variance"][mine])
        out["variance"][mine] *= share
    amplitude = random_numbers.complex_normals(key, 0, rays) * np.sqrt(out["variance"])
    amplitude = amplitude + out["mean_re"]
    out["amp_re"], out["amp_im"] = amplitude.real, amplitude.imag
    out["gain"] = physics.propagation_gain(range_m, azimuth, elevation, sonar)
    out["cos_incidence"], out["instance"] = cosine, instance
    for axis, name in enumerate("xyz"):
        out[name] = range_m * direction[..., axis]
    out = out[range_m <= sonar.range_max_m]
    return out[np.lexsort((out["delay_s"], out["beam"]))]


class Images:
    """Everything stored of one ping, polar [beams, samples]."""

    def __init__(self, sonar, scatterers, series):
        wanted = labels.PixelLabels(scatterers, sonar.bandwidth_hz, sonar.beams, sonar.samples)
        clean = physics.expected_power(scatterers, sonar)
        audible = wanted.has_echo & (clean >= (sonar.noise_power_pa2 or 0.0))
        self.instance = np.where(audible, wanted.instance, 0).astype(np.uint16)
        self.level = physics.level_db(series)
        self.labels = {
            "clean_db": physics.power_level_db(clean),
            "instance_fraction": np.where(audible, wanted.fraction, 0),
            "elevation_rad": wanted.elevation_mean,
            "elevation_std_rad": wanted.elevation_spread,
        }


def write(path, data):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as stream:
        stream.write(data if isinstance(data, bytes) else data.encode())


def cartesian_grid(sonar):
    scale = sonar.range_max_m / CARTESIAN_HEIGHT
    half = int(np.ceil(sonar.range_max_m * np.sin(sonar.spacing_rad * sonar.beams / 2) / scale))
    return Grid(CARTESIAN_HEIGHT, 2 * half, scale, sonar.range_max_m, half * scale)


def stated_grid(grid):
    return {
        "height_px": grid.height,
        "width_px": grid.width,
        "metres_per_pixel": grid.metres_per_pixel,
        "x_top_m": grid.x_top_m,
        "y_left_m": grid.y_left_m,
    }


def resampling_of(kind):
    """Of the Cartesian grey pictures: each of the two in some sequence."""
    return "nearest" if kind == "noisy" else "bilinear"


def write_images(folder, sonar, images, limits_db, exr_kinds, resampling):
    """Masks and grey pictures of ping 0 in both geometries, EXR in some; the COCO entries of both."""
    grid = cartesian_grid(sonar)
    fan = labels.CartesianMap(grid, sonar)
    place = {
        "metres_per_pixel": grid.metres_per_pixel,
        "x_top_m": grid.x_top_m,
        "y_left_m": grid.y_left_m,
    }
    axes = {
        "first_beam_azimuth_rad": sonar.azimuths_rad[0],
        "beam_spacing_rad": sonar.spacing_rad,
        "range_step_m": sonar.range_step_m,
    }
    smooth = labels.SmoothMap(grid, sonar)
    entries = []
    for kind, apply, numbers in (
        ("polar", lambda array, _: array.T, axes),
        ("cartesian", fan.apply, place),
    ):
        blank = {"clean_db": -99.0, "instance_fraction": 0.0}
        level = {"Y": apply(images.level, -99.0).astype("<f2")}
        channels = {
            name: apply(array, blank.get(name, np.nan)).astype("<f2")
            for name, array in images.labels.items()
        }
        instance = apply(images.instance, 0).astype(np.uint16)
        grey = apply(np.rint(labels.stored_grey_levels(images.level, *limits_db)[0]), 0).astype(np.uint8)
        if kind == "cartesian" and resampling == "bilinear":
            greys = labels.smooth_grey_levels(images.level, smooth, fan.inside, *limits_db)
            grey = np.where(fan.inside, np.rint(greys[0]), 0).astype(np.uint8)
        if kind in exr_kinds:
            parts = [("level", level, "none", numbers), ("labels", channels, "zip", numbers)]
            write(f"{folder}/{kind}/000000.exr", exr_bytes(parts))
        write(f"{folder}/{kind}/000000_instance.png", png_bytes(instance))
        # Class ids equal instance ids in this world.
        write(f"{folder}/{kind}/000000_semantic.png", png_bytes(instance.astype(np.uint8)))
        write(f"{folder}/png/000000_{kind}.png", png_bytes(grey))
        entries.append((kind, instance))
    polar_pixel = np.arange(sonar.samples * sonar.beams).reshape(sonar.samples, sonar.beams).T
    save_array(f"{folder}/cartesian_map.npy", fan.apply(polar_pixel, -1).astype(np.int32))
    return entries


def save_array(path, array):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    np.save(path, array)


def listing(folder, skip=()):
    """Manifest rows of all files below a folder."""
    rows = []
    for base, _, names in sorted(os.walk(folder)):
        for name in sorted(names):
            path = os.path.join(base, name)
            relative = os.path.relpath(path, folder)
            if relative.split(os.sep)[0] not in skip:
                with open(path, "rb") as stream:
                    data = stream.read()
                rows.append(
                    {
                        "path": relative,
                        "bytes": len(data),
                        "sha256": hashlib.sha256(data).hexdigest(),
                    }
                )
    return rows


def stated_shading(shading, width_rad):
    return {
        **dataclasses.asdict(shading),
        "aperture_wavelengths": aperture_wavelengths(shading, width_rad),
    }


def description(sonar, number, limits_db, kind="plain"):
    """sequence.json without its list of files."""
    return {
        "ensonify_sequence": 1,
        "sequence": number,
        "seed": SEED,
        "split": "train",
        "pings": [0, 1],
        "sonar": {
            "frequency_hz": sonar.frequency_hz,
            "bandwidth_hz": sonar.bandwidth_hz,
            "pulse": {"shape": sonar.pulse.shape, "duration_s": sonar.pulse.duration_s},
            "window": sonar.pulse.window,
            "processing_gain": 1.0,
            "adc": None if sonar.adc is None else dataclasses.asdict(sonar.adc),
            "source_level_db": 220.0,
            "range_min_m": 0.0,
            "range_max_m": 10.0,
            "normalization": "calibrated",
            "beams": {
                "count": sonar.beams,
                "spacing_rad": sonar.spacing_rad,
                "width_rad": sonar.width_rad,
                "transmit_width_rad": sonar.transmit_width_rad,
                "shading": stated_shading(sonar.shading, sonar.width_rad),
            },
            "elevation": {
                "width_rad": sonar.elevation_width_rad,
                "fan_rad": sonar.fan_rad,
                "shading": stated_shading(sonar.elevation_shading, sonar.elevation_width_rad),
            },
            "rays": {"elevation": sonar.rays_elevation, "azimuth": sonar.rays_azimuth},
        },
        "water": {"sound_speed_m_s": 1500.0, "absorption_db_m": sonar.absorption_db_m},
        "scattering": {"speckle": "per_ping"},
        "synthesis": {"tolerance": 1e-7},
        "noise": None
        if sonar.noise_power_pa2 is None
        else {
            "spectrum_level_db": sonar.noise_level_db,
            "snr_db": sonar.snr_db,
            "power_pa2": sonar.noise_power_pa2,
        },
        "record": {
            "samples": sonar.samples,
            "transform": len(sonar.spectrum),
            "pulse_extent_s": sonar.pulse.duration_s,
        },
        "png": {"db": list(limits_db), "resampling": resampling_of(kind)},
        "cartesian": stated_grid(cartesian_grid(sonar)),
        "classes": CLASSES,
        "instances": [
            {
                "id": i,
                "name": NAMES[i],
                "class": CLASSES[i - 1],
                "class_id": i,
                "kind": "surface",
                "law": {"model": "lambert", "reflectivity": MATERIALS[i], "exponent": 1.0},
                "material": NAMES[i],
                "vertex_reflectivity": False,
                "coherent": coherent_part(kind, i),
                "box": BOX if i == 1 else None,
            }
            for i in (1, 2)
        ],
    }


def make_series(sonar, number, scatterers):
    """Series of ping 0; sets the noise power where it is asked for by ratio."""
    series = physics.beam_series(scatterers, sonar)
    if sonar.snr_db is not None:
        echoes = labels.PixelLabels(scatterers, sonar.bandwidth_hz, sonar.beams, sonar.samples)
        clean = physics.expected_power(scatterers, sonar)
        sonar.stated_noise_pa2 = physics.snr_noise_power_pa2(sonar.snr_db, clean, echoes.has_echo)
    if sonar.noise_power_pa2 is not None:
        series = series + random_numbers.sample_noise(
            SEED, number, 0, sonar.beams, sonar.samples, sonar.noise_power_pa2
        )
    if sonar.adc is not None:
        series = physics.converted(series, sonar.adc.bits, sonar.adc.full_scale_db)
    return series.astype(np.complex64)


def write_sequence(root, number, kind):
    """One sequence folder; returns the masks for coco.json."""
    folder, sonar = f"{root}/sequences/{number:06d}", sonar_of(kind)
    scatterers = make_scatterers(sonar, number, kind)
    series = make_series(sonar, number, scatterers)
    save_array(f"{folder}/azimuth_rad.npy", sonar.azimuths_rad)
    save_array(f"{folder}/range_m.npy", np.arange(sonar.samples) * sonar.range_step_m)
    save_array(f"{folder}/timeseries/000000.npy", series)
    save_array(f"{folder}/scatterers/000000.npy", scatterers)
    returns = labels.first_return_m(scatterers, sonar.sound_speed_m_s, sonar.beams)
    save_array(f"{folder}/first_return_m.npy", returns[None].astype(np.float32))
    limits_db = (100.0, 160.0)
    exr_kinds = ("polar", "cartesian") if kind == "plain" else ("polar",)
    images = Images(sonar, scatterers, series)
    masks = write_images(folder, sonar, images, limits_db, exr_kinds, resampling_of(kind))
    numbers = ",".join(map(str, POSE))
    write(f"{folder}/poses.csv", f"ping,time_s,x,y,z,qw,qx,qy,qz\n0,0.0,{numbers}\n")
    write(f"{folder}/poses.tum", "0.0 0.0 0.0 0.0 0.0 0.0 0.0 1.0\n")
    write(
        f"{folder}/objects.csv",
        f"ping,instance,x,y,z,qw,qx,qy,qz\n0,1,{numbers}\n0,2,4{numbers[1:]}\n",
    )
    write(f"{folder}/boxes.csv", ",".join(BOXES_HEADER) + f"\n0,1,99.0,99.0,99.0,{numbers},{numbers}\n")
    write(f"{folder}/annotations.jsonl", annotation_line(masks) + "\n")
    info = description(sonar, number, limits_db, kind)
    info["files"] = listing(folder)
    info["bytes"] = sum(row["bytes"] for row in info["files"])
    write(f"{folder}/sequence.json", json.dumps(info))
    return [(f"sequences/{number:06d}/png/000000_{kind}.png", mask) for kind, mask in masks]


def write_data_set(root, kinds=("plain", "noisy")):
    """The whole data set, manifests last."""
    pictures = []
    for number, kind in enumerate(kinds):
        pictures += write_sequence(root, number, kind)
    write(f"{root}/coco.json", json.dumps(coco_of(pictures, CLASSES)))
    for name in ("README.md", "croissant.json", "work.json", "scenario.yaml"):
        write(f"{root}/{name}", "{}\n")
    stems = [f"{number:06d}/000000" for number in range(len(kinds))]
    write(
        f"{root}/index.csv",
        "sequence,ping,time_s,split,stem\n"
        + "".join(f"{i},0,0.0,train,{stem}\n" for i, stem in enumerate(stems)),
    )
    for split in ("train", "val", "test"):
        write(
            f"{root}/splits/{split}.txt",
            "".join(stem + "\n" for stem in stems) if split == "train" else "",
        )
    sequences = []
    for number in range(len(kinds)):
        folder = f"{root}/sequences/{number:06d}"
        own = next(row for row in listing(folder) if row["path"] == "sequence.json")
        total = sum(row["bytes"] for row in listing(folder))
        sequences.append(
            {
                "sequence": number,
                "pings": [0, 1],
                "seed": SEED,
                "split": "train",
                "bytes": total,
                "sha256": own["sha256"],
            }
        )
    files = listing(root, skip=("sequences",))
    manifest = json.dumps(
        {
            "ensonify_dataset": 1,
            "seed": SEED,
            "sequences": sequences,
            "files": files,
            "splits": {"train": list(range(len(kinds))), "val": [], "test": []},
            "classes": CLASSES,
            "bytes": sum(row["bytes"] for row in sequences + files),
        }
    )
    write(f"{root}/dataset.json", manifest)
    write(
        f"{root}/dataset.sha256", hashlib.sha256(manifest.encode()).hexdigest() + "  dataset.json\n"
    )
    write(f"{root}/provenance.json", "{}\n")

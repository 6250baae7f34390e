"""Faults for the self-test: each makes one thing wrong in a sound synthetic data set."""
import json
import os

import numpy as np

import random_numbers
import sonar_dataset
import synthetic_files
import synthetic_tank

SEQUENCE = "sequences/000000"
NOISY = "sequences/000001"


def change_array(path, change):
    def apply(root):
        array = np.load(f"{root}/{path}")
        np.save(f"{root}/{path}", change(array))

    return apply


def change_field(field, change):
    def edit(array):
        array[field] = change(array[field])
        return array

    return change_array(f"{SEQUENCE}/scatterers/000000.npy", edit)


def change_png(path, change):
    def apply(root):
        image = sonar_dataset.read_png(f"{root}/{path}")
        synthetic_tank.write(f"{root}/{path}", synthetic_files.png_bytes(change(image.copy())))

    return apply


def change_exr(path, part_name, channel, change):
    def apply(root):
        parts = []
        for part in sonar_dataset.read_exr(f"{root}/{path}"):
            numbers = {
                k: v for k, v in part.attributes.items() if k.endswith(("_m", "_pixel", "_rad"))
            }
            if part.name == part_name and channel in numbers:
                numbers[channel] = change(numbers[channel])
            channels = {
                k: change(v) if (part.name, k) == (part_name, channel) else v
                for k, v in part.channels.items()
            }
            parts.append((part.name, channels, part.compression, numbers))
        synthetic_tank.write(f"{root}/{path}", synthetic_files.exr_bytes(parts))

    return apply


def change_json(path, change):
    def apply(root):
        with open(f"{root}/{path}", encoding="utf-8") as stream:
            content = json.load(stream)
        change(content)
        synthetic_tank.write(f"{root}/{path}", json.dumps(content))

    return apply


def append_to(path, text):
    def apply(root):
        with open(f"{root}/{path}", "ab") as stream:
            stream.write(text.encode())

    return apply


def one_pixel(image):
    """Another id in the first pixel that has one."""
    row, column = np.argwhere(image > 0)[0]
    image[row, column] = 3 - image[row, column]
    return image


def scale_samples(factor):
    def edit(array):
        array = array.copy()
        array[:, 200:] *= factor
        return array

    return edit


def change_text(path, old, new):
    def apply(root):
        with open(f"{root}/{path}", encoding="utf-8") as stream:
            text = stream.read()
        synthetic_tank.write(f"{root}/{path}", text.replace(old, new))

    return apply


def remove(path):
    return lambda root: os.remove(f"{root}/{path}")


def move_annotation_box(content):
    content["annotations"][0]["bbox"][0] += 1


def swap_annotation_masks(content):
    first, second = content["annotations"][:2]
    first["segmentation"], second["segmentation"] = second["segmentation"], first["segmentation"]


def repeat_annotation_id(content):
    content["annotations"][1]["id"] = content["annotations"][0]["id"]


def shorten_picture(content):
    content["images"][0]["height"] -= 1


def drop_annotation(content):
    content["annotations"].pop()


def swap_categories(content):
    names = [entry["name"] for entry in content["categories"]]
    for entry, name in zip(content["categories"], reversed(names)):
        entry["name"] = name


def half_step(array):
    """Two steps of half precision in the pixel of the largest value."""
    row, column = np.unravel_index(np.nanargmax(array), array.shape)
    array = array.copy()
    array[row, column] += 2 * np.spacing(array[row, column])
    return array


def tilt(array):
    """A milliradian more in one pixel; the tank's own mean elevations are nearly zero."""
    array = array.copy()
    row, column = np.argwhere(np.isfinite(array))[0]
    array[row, column] += np.float16(1e-3)
    return array


def exchange_noise(series):
    """The noise of ping 1 in place of that of ping 0."""
    sonar = synthetic_tank.make_sonar(synthetic_tank.NOISE_LEVEL_DB)
    noise = [
        random_numbers.sample_noise(
            synthetic_tank.SEED, 1, ping, *series.shape, sonar.noise_power_pa2
        )
        for ping in (0, 1)
    ]
    return (series - noise[0] + noise[1]).astype(np.complex64)


def set_noise(content):
    content["noise"]["spectrum_level_db"] += 0.3


def scale_grid(content):
    content["cartesian"]["metres_per_pixel"] *= 1.002


def claim_smooth(content):
    content["png"]["resampling"] = "bilinear"


def later(array):
    """clean_db two samples late: the wall misses its place."""
    return np.roll(array, 2, axis=0)


def lift_shadow(array):
    """Fill the cylinder's shadow with the wall's level."""
    array = array.copy()
    middle = array.shape[1] // 2
    array[:, middle - 2 : middle + 2] = np.maximum(
        array[:, middle - 2 : middle + 2], array[:, middle - 9 : middle - 5]
    )
    return array


def stray_target(image):
    image[350, 100] = 2
    return image


POLAR, CARTESIAN = f"{SEQUENCE}/polar/000000", f"{SEQUENCE}/cartesian/000000"
SERIES = f"{SEQUENCE}/timeseries/000000.npy"

FAULTS = [
    ("a conjugate series", "check_series", change_array(SERIES, np.conj)),
    (
        "a series 0.02 % too strong",
        "check_series",
        change_array(SERIES, lambda a: a * np.complex64(1.0002)),
    ),
    ("mirrored beams", "check_series", change_array(SERIES, lambda a: a[::-1].copy())),
    (
        "a weak tenth off by a percent",
        "check_series",
        change_array(
            SERIES, lambda a: np.concatenate([a[:, :-40], a[:, -40:] * np.complex64(1.01)], axis=1)
        ),
    ),
    ("a series in double", "check_series", change_array(SERIES, lambda a: a.astype(np.complex128))),
    (
        "azimuths in float32 steps",
        "check_series",
        change_array(f"{SEQUENCE}/azimuth_rad.npy", lambda a: a + 1e-7),
    ),
    ("another noise level", "check_series", change_json(f"{NOISY}/sequence.json", set_noise)),
    (
        "other noise of the same level",
        "check_series",
        change_array(f"{NOISY}/timeseries/000000.npy", exchange_noise),
    ),
    ("gain off by 0.001 %", "check_scatterers", change_field("gain", lambda v: v * 1.00001)),
    ("delay of twice the slant way", "check_scatterers", change_field("delay_s", lambda v: v * 2)),
    ("elevation upside down", "check_scatterers", change_field("elevation_rad", lambda v: -v)),
    (
        "variance without the incidence",
        "check_scatterers",
        change_field("variance", lambda v: v * 0 + v.max()),
    ),
    (
        "amplitudes of other rays",
        "check_scatterers",
        change_field("amp_re", lambda v: np.roll(v, 1)),
    ),
    ("beams one off", "check_scatterers", change_field("beam", lambda v: np.minimum(v + 1, 127))),
    ("a wrong instance pixel", "check_labels", change_png(f"{POLAR}_instance.png", one_pixel)),
    ("a wrong semantic pixel", "check_labels", change_png(f"{POLAR}_semantic.png", one_pixel)),
    ("a wrong Cartesian pixel", "check_labels", change_png(f"{CARTESIAN}_instance.png", one_pixel)),
    (
        "a Cartesian mask one column off",
        "check_labels",
        change_png(f"{CARTESIAN}_instance.png", lambda a: np.roll(a, 1, axis=1)),
    ),
    (
        "another Cartesian scale",
        "check_labels",
        change_exr(f"{CARTESIAN}.exr", "level", "metres_per_pixel", lambda v: v * 1.002),
    ),
    (
        "another range step",
        "check_labels",
        change_exr(f"{POLAR}.exr", "labels", "range_step_m", lambda v: v * 1.001),
    ),
    (
        "a Cartesian image moved",
        "check_labels",
        change_exr(f"{CARTESIAN}.exr", "labels", "y_left_m", lambda v: v + 0.2),
    ),
    (
        "a Cartesian map one pixel off",
        "check_labels",
        change_array(f"{SEQUENCE}/cartesian_map.npy", lambda a: np.roll(a, 1, axis=1)),
    ),
    (
        "a Cartesian mask without level image one column off",
        "check_labels",
        change_png(f"{NOISY}/cartesian/000000_instance.png", lambda a: np.roll(a, 1, axis=1)),
    ),
    (
        "another Cartesian scale in sequence.json",
        "check_labels",
        change_json(f"{NOISY}/sequence.json", scale_grid),
    ),
    ("no Cartesian map", "check_files", remove(f"{NOISY}/cartesian_map.npy")),
    ("a wrong level", "check_labels", change_exr(f"{POLAR}.exr", "level", "Y", half_step)),
    (
        "a wrong clean_db",
        "check_labels",
        change_exr(f"{POLAR}.exr", "labels", "clean_db", half_step),
    ),
    (
        "a wrong elevation",
        "check_labels",
        change_exr(f"{POLAR}.exr", "labels", "elevation_rad", tilt),
    ),
    (
        "a wrong elevation spread",
        "check_labels",
        change_exr(f"{POLAR}.exr", "labels", "elevation_std_rad", half_step),
    ),
    (
        "a wrong instance_fraction",
        "check_labels",
        change_exr(f"{POLAR}.exr", "labels", "instance_fraction", half_step),
    ),
    (
        "a grey picture of amplitude",
        "check_labels",
        change_png(
            f"{SEQUENCE}/png/000000_polar.png",
            lambda a: (a.astype(int) ** 2 // 255).astype(np.uint8),
        ),
    ),
    (
        "a Cartesian grey picture one row off",
        "check_labels",
        change_png(f"{SEQUENCE}/png/000000_cartesian.png", lambda a: np.roll(a, 1, axis=0)),
    ),
    (
        "a Cartesian grey picture of the nearest pixels",
        "check_labels",
        change_json(f"{NOISY}/sequence.json", claim_smooth),
    ),
    (
        "a wrong first return",
        "check_labels",
        change_array(f"{SEQUENCE}/first_return_m.npy", lambda a: a + 1e-3),
    ),
    ("a box one pixel off", "check_coco", change_json("coco.json", move_annotation_box)),
    ("masks exchanged", "check_coco", change_json("coco.json", swap_annotation_masks)),
    ("an id given twice", "check_coco", change_json("coco.json", repeat_annotation_id)),
    ("a picture of another size", "check_coco", change_json("coco.json", shorten_picture)),
    ("an annotation left out", "check_coco", change_json("coco.json", drop_annotation)),
    ("categories exchanged", "check_coco", change_json("coco.json", swap_categories)),
    (
        "annotations.jsonl of another area",
        "check_coco",
        change_text(f"{SEQUENCE}/annotations.jsonl", '"area": ', '"area": 1'),
    ),
    ("a picture that is not there", "check_coco", remove(f"{SEQUENCE}/png/000000_polar.png")),
    (
        "the wall two samples late",
        "check_physics_tank",
        change_exr(f"{POLAR}.exr", "labels", "clean_db", later),
    ),
    (
        "no shadow",
        "check_physics_tank",
        change_exr(f"{POLAR}.exr", "labels", "clean_db", lift_shadow),
    ),
    (
        "a stray cylinder pixel",
        "check_physics_tank",
        change_png(f"{POLAR}_instance.png", stray_target),
    ),
    (
        "a ray that meets nothing",
        "check_physics_tank",
        change_array(f"{SEQUENCE}/scatterers/000000.npy", lambda a: a[1:]),
    ),
    (
        "an early first return",
        "check_physics_tank",
        change_array(f"{SEQUENCE}/first_return_m.npy", lambda a: a - 0.05),
    ),
    ("a flipped bit of the series", "check_files", change_array(SERIES, np.negative)),
    ("a foreign file", "check_files", append_to(f"{SEQUENCE}/polar/000000.exr.tmp", "x")),
    ("an absent mask", "check_files", remove(f"{POLAR}_semantic.png")),
    ("a changed manifest", "check_files", append_to("dataset.json", " ")),
    ("a changed split", "check_files", append_to("splits/val.txt", "000000/000000\n")),
    (
        "poses.tum of another time",
        "check_files",
        append_to(f"{SEQUENCE}/poses.tum", "1 0 0 0 0 0 0 1\n"),
    ),
    ("a box of another size", "check_files", change_text(f"{SEQUENCE}/boxes.csv", ",99.0,", ",98.0,")),
    ("a time of day", "check_files", append_to("README.md", "made 2024-05-06 07:08\n")),
    ("a column too many", "check_files", append_to("index.csv", "0,1,0,train,x,y\n")),
]

# The same for the data set of synthetic_room.py.
ROOM_FAULTS = [
    (
        "hits of another object",
        "check_trace",
        change_field("instance", lambda v: np.where(np.arange(len(v)) < 9, 3, v)),
    ),
    ("ranges 1 um off", "check_trace", change_field("delay_s", lambda v: v + 1.4e-9)),
    ("incidence squared", "check_trace", change_field("cos_incidence", lambda v: v**2)),
    (
        "a variance without its solid angle",
        "check_trace",
        change_field("variance", lambda v: v * 1.001),
    ),
    ("a target 1 dB weaker", "check_trace", change_field("amp_re", lambda v: v * 0.891)),
    (
        "hidden targets heard",
        "check_trace",
        change_field("instance", lambda v: np.where(v == 6, 7, v)),
    ),
    (
        "pings at another rate",
        "check_trace",
        change_text(f"{SEQUENCE}/poses.csv", "\n1,2.0,", "\n1,2.001,"),
    ),
    (
        "an object elsewhere",
        "check_trace",
        change_text(f"{SEQUENCE}/objects.csv", "0,4,3.0,", "0,4,3.1,"),
    ),
]

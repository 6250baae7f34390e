"""Faults for the self-test: each makes one thing wrong in a sound data set, and one check must find it.

The lists at the end map a check to its faults, and a fault's name to the change of the data set's folder.
"""
import csv
import json
import os

import numpy as np

import random_numbers
import sonar_dataset
import writers
from sequence import DataSet

SEQUENCE = "sequences/000000"
DESCRIPTION = f"{SEQUENCE}/sequence.json"
POLAR, CARTESIAN = f"{SEQUENCE}/polar/000000", f"{SEQUENCE}/cartesian/000000"
SERIES, ECHOES = f"{SEQUENCE}/timeseries/000000.npy", f"{SEQUENCE}/scatterers/000000.npy"


def write(path, data):
    with open(path, "wb") as stream:
        stream.write(data if isinstance(data, bytes) else data.encode())


def change_array(path, change):
    def apply(root):
        np.save(f"{root}/{path}", change(np.load(f"{root}/{path}")))

    return apply


def change_field(field, change):
    def edit(array):
        array[field] = change(array[field])
        return array

    return change_array(ECHOES, edit)


def change_png(path, change):
    def apply(root):
        image = sonar_dataset.read_png(f"{root}/{path}")
        write(f"{root}/{path}", writers.png_bytes(change(image.copy())))

    return apply


def change_exr(path, part_name, channel, change):
    """Change of a channel, or of a number in the header."""

    def apply(root):
        parts = []
        for part in sonar_dataset.read_exr(f"{root}/{path}"):
            numbers = {
                k: v for k, v in part.attributes.items() if k.endswith(("_m", "_pixel", "_rad"))
            }
            if part.name == part_name and channel in numbers:
                numbers[channel] = change(numbers[channel])
            channels = {
                k: change(v.copy()) if (part.name, k) == (part_name, channel) else v
                for k, v in part.channels.items()
            }
            parts.append((part.name, channels, part.compression, numbers))
        write(f"{root}/{path}", writers.exr_bytes(parts))

    return apply


def change_json(path, change):
    def apply(root):
        with open(f"{root}/{path}", encoding="utf-8") as stream:
            content = json.load(stream)
        change(content)
        write(f"{root}/{path}", json.dumps(content))

    return apply


def described(*keys, value=None, factor=None):
    """A change of one entry of sequence.json: another value, or one times a factor."""

    def change(content):
        for key in keys[:-1]:
            content = content[key]
        content[keys[-1]] = value if factor is None else content[keys[-1]] * factor

    return change_json(DESCRIPTION, change)


def change_cell(path, row, column, change):
    """Change of a number in a row of a table, rows counted from 0."""

    def apply(root):
        header, rows = sonar_dataset.read_csv(f"{root}/{path}")
        at = header.index(column)
        rows[row][at] = repr(change(float(rows[row][at])))
        with open(f"{root}/{path}", "w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([header, *rows])

    return apply


def change_text(path, old, new):
    def apply(root):
        with open(f"{root}/{path}", encoding="utf-8") as stream:
            text = stream.read()
        write(f"{root}/{path}", text.replace(old, new))

    return apply


def append_to(path, text):
    def apply(root):
        with open(f"{root}/{path}", "ab") as stream:
            stream.write(text.encode())

    return apply


def remove(path):
    return lambda root: os.remove(f"{root}/{path}")


def one_pixel(image):
    """Another id in the first pixel that has one."""
    row, column = np.argwhere(image > 0)[0]
    image[row, column] = 3 - image[row, column]
    return image


def stray_target(image):
    image[350, 100] = 2
    return image


def next_column(array):
    return np.roll(array, 1, axis=1)


def half_step(array):
    """Two steps of half precision in the pixel of the largest value."""
    row, column = np.unravel_index(np.nanargmax(array), array.shape)
    array[row, column] += 2 * np.spacing(array[row, column])
    return array


def tilt(array):
    """A milliradian more in one pixel; the tank's own mean elevations are nearly zero."""
    row, column = np.argwhere(np.isfinite(array))[0]
    array[row, column] += np.float16(1e-3)
    return array


def lift_shadow(array):
    """Fill the cylinder's shadow with the wall's level."""
    middle = array.shape[1] // 2
    array[:, middle - 2 : middle + 2] = np.maximum(
        array[:, middle - 2 : middle + 2], array[:, middle - 9 : middle - 5]
    )
    return array


def weaker_end(series):
    series[:, -40:] *= np.complex64(1.01)
    return series


def exchange_noise(root):
    """The noise of ping 1 in place of that of ping 0."""
    sequence = DataSet(root).sequences[0]
    series, power = sequence.series(0), sequence.sonar.noise_power_pa2
    noise = [random_numbers.sample_noise(sequence.seed, 0, ping, *series.shape, power) for ping in (0, 1)]
    np.save(f"{root}/{SERIES}", (series - noise[0] + noise[1]).astype(np.complex64))


def one_step(root):
    """The loudest sample, one step of the converter up."""
    sequence = DataSet(root).sequences[0]
    series = sequence.series(0).copy()
    series.reshape(-1)[abs(series).argmax()] += sequence.sonar.adc.step_pa
    np.save(f"{root}/{SERIES}", series)


def in_coco(change):
    return change_json("coco.json", change)


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


# scenes/sonar_tank.yaml, small, with Cartesian level images.
TANK = {
    "check_series": {
        "a conjugate series": change_array(SERIES, np.conj),
        "a series 0.02 % too strong": change_array(SERIES, lambda a: a * np.complex64(1.0002)),
        "mirrored beams": change_array(SERIES, lambda a: a[::-1].copy()),
        "a weak tenth off by a percent": change_array(SERIES, weaker_end),
        "a series in double": change_array(SERIES, lambda a: a.astype(np.complex128)),
        "azimuths in float32 steps": change_array(f"{SEQUENCE}/azimuth_rad.npy", lambda a: a + 1e-7),
    },
    "check_scatterers": {
        "gain off by 0.001 %": change_field("gain", lambda v: v * 1.00001),
        "delay of twice the slant way": change_field("delay_s", lambda v: v * 2),
        "elevation upside down": change_field("elevation_rad", lambda v: -v),
        "variance without the incidence": change_field("variance", lambda v: v * 0 + v.max()),
        "amplitudes of other rays": change_field("amp_re", lambda v: np.roll(v, 1)),
        "beams one off": change_field("beam", lambda v: np.minimum(v + 1, 127)),
    },
    "check_labels": {
        "a wrong instance pixel": change_png(f"{POLAR}_instance.png", one_pixel),
        "a wrong semantic pixel": change_png(f"{POLAR}_semantic.png", one_pixel),
        "a wrong Cartesian pixel": change_png(f"{CARTESIAN}_instance.png", one_pixel),
        "a Cartesian mask one column off": change_png(f"{CARTESIAN}_instance.png", next_column),
        "another Cartesian scale": change_exr(f"{CARTESIAN}.exr", "level", "metres_per_pixel", lambda v: v * 1.002),
        "another range step": change_exr(f"{POLAR}.exr", "labels", "range_step_m", lambda v: v * 1.001),
        "a Cartesian image moved": change_exr(f"{CARTESIAN}.exr", "labels", "y_left_m", lambda v: v + 0.2),
        "a Cartesian map one pixel off": change_array(f"{SEQUENCE}/cartesian_map.npy", next_column),
        "a wrong level": change_exr(f"{POLAR}.exr", "level", "Y", half_step),
        "a wrong clean_db": change_exr(f"{POLAR}.exr", "labels", "clean_db", half_step),
        "a clean_db two samples late": change_exr(
            f"{POLAR}.exr", "labels", "clean_db", lambda a: np.roll(a, 2, axis=0)
        ),
        "no shadow": change_exr(f"{POLAR}.exr", "labels", "clean_db", lift_shadow),
        "a wrong elevation": change_exr(f"{POLAR}.exr", "labels", "elevation_rad", tilt),
        "a wrong elevation spread": change_exr(f"{POLAR}.exr", "labels", "elevation_std_rad", half_step),
        "a wrong instance_fraction": change_exr(f"{POLAR}.exr", "labels", "instance_fraction", half_step),
        "a grey picture of amplitude": change_png(
            f"{SEQUENCE}/png/000000_polar.png", lambda a: (a.astype(int) ** 2 // 255).astype(np.uint8)
        ),
        "a Cartesian grey picture one row off": change_png(
            f"{SEQUENCE}/png/000000_cartesian.png", lambda a: np.roll(a, 1, axis=0)
        ),
        "a Cartesian grey picture of the mean over pixels": described("png", "resampling", value="nearest"),
        "a wrong first return": change_array(f"{SEQUENCE}/first_return_m.npy", lambda a: a + 1e-3),
    },
    "check_coco": {
        "a box one pixel off": in_coco(move_annotation_box),
        "masks exchanged": in_coco(swap_annotation_masks),
        "an id given twice": in_coco(repeat_annotation_id),
        "a picture of another size": in_coco(shorten_picture),
        "an annotation left out": in_coco(drop_annotation),
        "categories exchanged": in_coco(swap_categories),
        "annotations.jsonl of another area": change_text(f"{SEQUENCE}/annotations.jsonl", '"area":', '"area":1'),
        "a picture that is not there": remove(f"{SEQUENCE}/png/000000_polar.png"),
    },
    "check_physics_tank": {
        "a stray cylinder pixel": change_png(f"{POLAR}_instance.png", stray_target),
        "a ray that meets nothing": change_array(ECHOES, lambda a: a[1:]),
        "an early first return": change_array(f"{SEQUENCE}/first_return_m.npy", lambda a: a - 0.05),
    },
    "check_files": {
        "a flipped bit of the series": change_array(SERIES, np.negative),
        "a foreign file": append_to(f"{POLAR}.exr.tmp", "x"),
        "an absent mask": remove(f"{POLAR}_semantic.png"),
        "no Cartesian map": remove(f"{SEQUENCE}/cartesian_map.npy"),
        "a changed manifest": append_to("dataset.json", " "),
        "a changed split": append_to("splits/val.txt", "000000/000000\n"),
        "poses.tum of another time": append_to(f"{SEQUENCE}/poses.tum", "1 0 0 0 0 0 0 1\n"),
        "a box of another size": change_cell(f"{SEQUENCE}/boxes.csv", 0, "size_y", lambda v: v - 1),
        "a time of day": append_to("README.md", "made 2024-05-06 07:08\n"),
        "a column too many": append_to("index.csv", "0,1,0,train,x,y\n"),
    },
}

# The same tank with noise of a known level, and no Cartesian level images.
NOISY_TANK = {
    "check_series": {
        "another noise level": described("noise", "spectrum_level_db", value=60.3),
        "other noise of the same level": exchange_noise,
    },
    "check_labels": {
        "a Cartesian mask without level image one column off": change_png(f"{CARTESIAN}_instance.png", next_column),
        "another Cartesian scale in sequence.json": described("cartesian", "metres_per_pixel", factor=1.002),
    },
}

# shaded_room.yaml as a burst through a converter.
BURST = {
    "check_series": {
        "a sample one step off": one_step,
        "samples between steps": change_array(SERIES, lambda a: a * np.complex64(1.0002)),
        "another full scale": described("sonar", "adc", "full_scale_db", value=150.1),
        "another step": described("sonar", "adc", "step_pa", factor=1.001),
        "another ratio to the noise": described("noise", "snr_db", value=25.1),
        "another window": described("sonar", "window", value="hann"),
        "another burst": described("sonar", "pulse", "duration_s", factor=1.02),
        "another shading": described("sonar", "beams", "shading", "kind", value="chebyshev"),
    },
    "check_scatterers": {
        "another pattern in elevation": described("sonar", "elevation", "shading", "kind", value="chebyshev"),
        "another transmit pattern": described("sonar", "beams", "transmit_width_rad", factor=1.0001),
        "another K": described("instances", 2, "coherent", "k", value=0.501),
        "another exponent": described("instances", 2, "law", "exponent", value=1.01),
        "another law": described("instances", 0, "law", "model", value="lambert"),
    },
    "check_labels": {
        "another number of looks": described("sonar", "detector", "looks", value=2),
        "another floor": described("sonar", "detector", "floor_db", value=106.0),
        "another noise of the detector": described("sonar", "detector", "noise_db", value=1.01),
        "another integration": described("sonar", "detector", "integrate", value=1.51),
        "another law": described("sonar", "detector", "law", value="amplitude"),
    },
    "check_files": {
        "a shorter aperture": described("sonar", "beams", "shading", "aperture_wavelengths", factor=0.999),
        "a lower aperture": described("sonar", "elevation", "shading", "aperture_wavelengths", factor=0.999),
        "a longer pulse": described("record", "pulse_extent_s", factor=1.01),
        "a gain of nothing": described("sonar", "processing_gain", value=2.0),
    },
}

# turning_room.yaml.
ROOM = {
    "check_trace": {
        "hits of another object": change_field("instance", lambda v: np.where(np.arange(len(v)) < 9, 3, v)),
        "ranges 1 um off": change_field("delay_s", lambda v: v + 1.4e-9),
        "incidence squared": change_field("cos_incidence", lambda v: v**2),
        "a variance without its solid angle": change_field("variance", lambda v: v * 1.001),
        "a target 1 dB weaker": change_field("amp_re", lambda v: v * 0.891),
        "hidden targets heard": change_field("instance", lambda v: np.where(v == 6, 7, v)),
        "pings at another rate": change_cell(f"{SEQUENCE}/poses.csv", 1, "time_s", lambda v: v + 1e-3),
        "an object elsewhere": change_cell(f"{SEQUENCE}/objects.csv", 3, "x", lambda v: v + 0.1),
    },
}

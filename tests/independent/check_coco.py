#!/usr/bin/python3
"""Reads coco.json by COCO's published format and holds it against the images and masks.

    check_coco.py DATASET_DIR

Ids are unique and refer to what exists, files exist in the stated size, every run-length mask
is exactly the instance's pixels in the mask PNG, and area and box [x, y, width, height]
follow from that mask. Every instance of every mask has its annotation. Amodal masks hold the
visible ones, and what is hidden altogether stands in a list of its own.
"""
import json
import os
import re
import sys

import numpy as np

from checklist import run_main
from sequence import IMAGE_KINDS, DataSet
from sonar_dataset import decode_rle, read_exr, read_json, read_png

# A picture is a grey PNG or, in a data set without those, a level image.
PICTURE = re.compile(
    r"sequences/(\d+)/(?:png/(\d+)_(polar|cartesian)\.png|(polar|cartesian)/(\d+)\.exr)$"
)


def check_ids(checklist, coco):
    """Ids are unique; annotations refer to images and categories that are there."""
    for what in ("images", "annotations", "categories"):
        ids = [entry["id"] for entry in coco[what]]
        repeated = sorted({i for i in ids if ids.count(i) > 1}) if len(set(ids)) != len(ids) else []
        checklist.expect_none(repeated, f"{what}: {len(ids)} ids, given twice")
        whole = [i for i in ids if not isinstance(i, int) or i < 1]
        checklist.expect_none(whole, f"{what}: ids that are not whole numbers from 1")
    images = {entry["id"] for entry in coco["images"]}
    categories = {entry["id"] for entry in coco["categories"]}
    lost = [
        a["id"]
        for a in coco["annotations"]
        if a["image_id"] not in images or a["category_id"] not in categories
    ]
    checklist.expect_none(lost, "annotations of unknown images or categories")
    names = [entry["name"] for entry in coco["categories"]]
    checklist.expect(len(set(names)) == len(names), "category names", names, "each once")


def check_categories(checklist, coco, sequences):
    """Categories are the classes of the semantic masks, number by number."""
    by_id = {entry["id"]: entry["name"] for entry in coco["categories"]}
    offenders = [
        f"{instance.name}: class {instance.class_id} {instance.class_name!r}, coco says "
        f"{by_id.get(instance.class_id)!r}"
        for sequence in sequences.values()
        for instance in sequence.instances.values()
        if by_id.get(instance.class_id) != instance.class_name
    ]
    checklist.expect_none(offenders, "instances whose class is not the category of that id")


def check_images(checklist, coco, data_set, sequences):
    """Every picture is listed once with its size, and nothing else is."""
    named = [entry["file_name"] for entry in coco["images"]]
    expected = {
        f"sequences/{name}/png/{ping:06d}_{kind}.png"
        if sequence.has("png")
        else f"sequences/{name}/{kind}/{ping:06d}.exr"
        for name, sequence in sequences.items()
        for ping in sequence.pings
        for kind in IMAGE_KINDS
        if sequence.has(kind)
    }
    checklist.expect(
        sorted(named) == sorted(expected),
        "images listed",
        f"{len(named)} {sorted(named)[:2]}",
        f"{len(expected)} {sorted(expected)[:2]}",
    )
    wrong = []
    for entry in coco["images"]:
        path = data_set.path(entry["file_name"])
        if not os.path.exists(path):
            wrong.append(f"{entry['file_name']} does not exist")
            continue
        shape = read_png(path).shape if path.endswith(".png") else read_exr(path)[0].shape
        if shape != (entry["height"], entry["width"]):
            wrong.append(
                f"{entry['file_name']} is {shape}, listed {entry['height']} x {entry['width']}"
            )
    checklist.expect_none(wrong, "images that are absent or of another size")


def mask_of_image(sequences, file_name):
    """Instance mask PNG that belongs to a picture, or None."""
    match = PICTURE.search(file_name)
    if not match or match.group(1) not in sequences:
        return None, None
    sequence = sequences[match.group(1)]
    kind, ping = match.group(3) or match.group(4), match.group(2) or match.group(5)
    return sequence, sequence.mask(kind, int(ping), "instance")


def bounding_box(mask):
    """[x, y, width, height] that encloses a mask's pixels exactly."""
    rows, columns = np.nonzero(mask.any(axis=1))[0], np.nonzero(mask.any(axis=0))[0]
    return [
        int(columns[0]),
        int(rows[0]),
        int(columns[-1] - columns[0] + 1),
        int(rows[-1] - rows[0] + 1),
    ]


def annotation_faults(annotation, image, instance_mask, class_of):
    """Faults of one annotation, and the instance its mask is of."""
    segmentation = annotation["segmentation"]
    if list(segmentation["size"]) != [image["height"], image["width"]]:
        return [f"size {segmentation['size']}"], None
    mask = decode_rle(segmentation["counts"], image["height"], image["width"])
    covered = np.unique(instance_mask[mask]) if mask.any() else np.zeros(0, int)
    if len(covered) != 1 or covered[0] == 0:
        return [f"mask covers the instances {covered.tolist()}"], None
    identity = int(covered[0])
    faults = []
    if not np.array_equal(mask, instance_mask == identity):
        faults.append(
            f"mask has {mask.sum()} pixels, the PNG {np.count_nonzero(instance_mask == identity)}"
        )
    if annotation["area"] != mask.sum():
        faults.append(f"area {annotation['area']}, mask {mask.sum()}")
    if list(annotation["bbox"]) != bounding_box(mask):
        faults.append(f"box {annotation['bbox']}, mask's {bounding_box(mask)}")
    if annotation["iscrowd"] not in (0, 1):
        faults.append(f"iscrowd {annotation['iscrowd']}")
    if annotation["category_id"] != class_of.get(identity):
        faults.append(
            f"category {annotation['category_id']}, "
            f"instance {identity} has {class_of.get(identity)}"
        )
    return faults, identity


def check_annotations(checklist, coco, sequences):
    """Each annotation is one instance's pixels, and each instance's pixels are annotated."""
    by_image = {}
    for annotation in coco["annotations"]:
        by_image.setdefault(annotation["image_id"], []).append(annotation)
    faults, missing, count = [], [], 0
    for image in coco["images"]:
        sequence, instance_mask = mask_of_image(sequences, image["file_name"])
        if instance_mask is None:
            faults.append(f"{image['file_name']} belongs to no sequence")
            continue
        class_of = {identity: entry.class_id for identity, entry in sequence.instances.items()}
        found = []
        for annotation in by_image.get(image["id"], []):
            wrong, identity = annotation_faults(annotation, image, instance_mask, class_of)
            faults += [f"annotation {annotation['id']}: {text}" for text in wrong]
            found.append(identity)
            count += 1
        present = sorted(set(np.unique(instance_mask).tolist()) - {0})
        if sorted(i for i in found if i is not None) != present:
            missing.append(f"{image['file_name']}: annotated {found}, in the mask {present}")
    checklist.expect_none(faults, f"{count} annotations, faults")
    checklist.expect_none(missing, "images whose annotations are not its instances")


def amodal_mask_of(annotation, image, faults):
    """The amodal mask of an annotation or a hidden entry, checked for itself."""
    segmentation = annotation["amodal_segmentation"]
    mask = decode_rle(segmentation["counts"], image["height"], image["width"])
    share = annotation["occlusion"]
    if list(segmentation["size"]) != [image["height"], image["width"]] or not mask.any():
        faults.append("amodal size, or no pixel")
        return None
    if annotation["amodal_area"] != mask.sum() or annotation["amodal_bbox"] != bounding_box(mask):
        faults.append(f"amodal area {annotation['amodal_area']}, box {annotation['amodal_bbox']}")
    if share is not None and not 0 <= share <= 1:
        faults.append(f"occlusion {share}")
    return mask


def check_amodal(checklist, coco):
    """Amodal masks of what is seen and of what is hidden."""
    images = {image["id"]: image for image in coco["images"]}
    faults, seen = [], set()
    for annotation in coco["annotations"]:
        seen.add((annotation["image_id"], annotation.get("instance_id")))
        if "amodal_segmentation" not in annotation:
            continue
        image = images[annotation["image_id"]]
        mask = amodal_mask_of(annotation, image, faults)
        visible = decode_rle(
            annotation["segmentation"]["counts"], image["height"], image["width"]
        )
        if mask is not None and (visible & ~mask).any():
            faults.append(f"annotation {annotation['id']}: visible where it is not amodal")
    for entry in coco.get("hidden", []):
        if (entry["image_id"], entry["instance_id"]) in seen:
            faults.append(f"image {entry['image_id']}: {entry['name']} is both hidden and seen")
        amodal_mask_of(entry, images[entry["image_id"]], faults)
    checklist.expect_none(faults, f"amodal masks and {len(coco.get('hidden', []))} hidden, faults")


def check_annotation_lines(checklist, coco, sequences):
    """annotations.jsonl of every sequence holds what coco.json does."""
    by_image = {}
    for entry in coco["annotations"]:
        by_image.setdefault(entry["image_id"], []).append(
            (entry["bbox"], entry["area"], entry["segmentation"]["counts"])
        )
    gathered = {
        image["file_name"]: (image["width"], image["height"], by_image.get(image["id"], []))
        for image in coco["images"]
    }
    faults, lines = [], {}
    for name, sequence in sequences.items():
        with open(sequence.path("annotations.jsonl"), encoding="utf-8") as stream:
            records = [json.loads(line) for line in stream]
        if [(r["ping"], r["time_s"]) for r in records] != [
            (p, sequence.time_s(p)) for p in sequence.pings
        ]:
            faults.append(f"{name}: pings or times are not those of poses.csv")
        lines |= {
            f"sequences/{name}/{image['file']}": (
                image["width"],
                image["height"],
                [(a["bbox"], a["area"], a["counts"]) for a in image["annotations"]],
            )
            for record in records
            for image in record["images"]
            if "file" in image  # masks without an image have none
        }
    faults += [
        path for path in sorted(set(lines) | set(gathered)) if lines.get(path) != gathered.get(path)
    ]
    checklist.expect_none(faults, f"annotations.jsonl unlike coco.json, {len(lines)} pictures")


def check(checklist, root):
    data_set = DataSet(root)
    coco = read_json(data_set.path("coco.json"))
    sequences = {sequence.name: sequence for sequence in data_set.sequences}
    check_ids(checklist, coco)
    check_categories(checklist, coco, sequences)
    check_images(checklist, coco, data_set, sequences)
    check_annotations(checklist, coco, sequences)
    check_annotation_lines(checklist, coco, sequences)
    check_amodal(checklist, coco)


if __name__ == "__main__":
    sys.exit(run_main("check_coco", check))

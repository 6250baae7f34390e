"""COCO annotations of instance masks, for the synthetic tank."""
import json

import numpy as np

from synthetic_files import encode_rle


def annotations_of(mask):
    """Boxes and run lengths of a mask, as annotations.jsonl has them."""
    entries = []
    for identity in sorted(set(np.unique(mask).tolist()) - {0}):
        rows, columns = np.nonzero(mask == identity)
        box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
        entries.append(
            {
                "instance": identity,
                "bbox": [int(v) for v in box],
                "area": len(rows),
                "counts": encode_rle(mask == identity),
            }
        )
    return entries


def annotation_line(masks):
    """The line of ping 0 in annotations.jsonl."""
    return json.dumps(
        {
            "ping": 0,
            "time_s": 0.0,
            "images": [
                {
                    "view": kind,
                    "file": f"png/000000_{kind}.png",
                    "width": mask.shape[1],
                    "height": mask.shape[0],
                    "annotations": annotations_of(mask),
                }
                for kind, mask in masks
            ],
        }
    )


def coco_of(pictures, classes):
    """coco.json of (file name, instance mask) pairs."""
    images, annotations = [], []
    for file_name, mask in pictures:
        images.append(
            {
                "id": len(images) + 1,
                "file_name": file_name,
                "height": mask.shape[0],
                "width": mask.shape[1],
            }
        )
        for entry in annotations_of(mask):
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": images[-1]["id"],
                    "category_id": entry["instance"],
                    "area": entry["area"],
                    "bbox": entry["bbox"],
                    "iscrowd": 0,
                    "segmentation": {"size": list(mask.shape), "counts": entry["counts"]},
                }
            )
    return {
        "images": images,
        "annotations": annotations,
        "categories": [{"id": i + 1, "name": name} for i, name in enumerate(classes)],
    }

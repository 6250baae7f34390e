#!/usr/bin/python3
"""Compares two data sets byte for byte, provenance.json excepted, and lists the differences.

    compare_datasets.py DATASET_A DATASET_B
"""
import os
import sys

from checklist import run_main

NEVER_COMPARED = {"provenance.json"}
BLOCK_BYTES = 1 << 20


def tree(root):
    """Relative paths of all files, links and folders below root."""
    paths = set()
    for folder, folders, files in os.walk(root):
        base = os.path.relpath(folder, root)
        for name in files:
            paths.add(os.path.normpath(os.path.join(base, name)))
        for name in folders:
            paths.add(os.path.normpath(os.path.join(base, name)) + os.sep)
    return paths - NEVER_COMPARED


def first_difference(path_a, path_b):
    """Offset of the first byte that differs, None where there is none."""
    offset = 0
    with open(path_a, "rb") as a, open(path_b, "rb") as b:
        while True:
            block_a, block_b = a.read(BLOCK_BYTES), b.read(BLOCK_BYTES)
            if block_a != block_b:
                shorter = min(len(block_a), len(block_b))
                same = next((i for i in range(shorter) if block_a[i] != block_b[i]), shorter)
                return offset + same
            if not block_a:
                return None
            offset += len(block_a)


def check(checklist, root_a, root_b):
    paths_a, paths_b = tree(root_a), tree(root_b)
    checklist.expect(bool(paths_a), "entries in the first", len(paths_a), "some")
    checklist.expect_none(sorted(paths_a - paths_b), "only in the first", 20)
    checklist.expect_none(sorted(paths_b - paths_a), "only in the second", 20)
    differing = []
    for path in sorted(paths_a & paths_b):
        if path.endswith(os.sep):
            continue
        offset = first_difference(os.path.join(root_a, path), os.path.join(root_b, path))
        if offset is not None:
            sizes = [os.path.getsize(os.path.join(root, path)) for root in (root_a, root_b)]
            differing.append(f"{path} from byte {offset} on ({sizes[0]} and {sizes[1]} bytes)")
    checklist.expect_none(differing, f"{len(paths_a & paths_b)} common entries, differing", 20)


if __name__ == "__main__":
    sys.exit(run_main("compare_datasets", check, argument_count=2))

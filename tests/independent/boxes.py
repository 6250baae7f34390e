"""3-D boxes worked out again from the instances' boxes and the poses."""

import numpy as np

import sonar_dataset

POSE_COLUMNS = ["x", "y", "z", "qw", "qx", "qy", "qz"]
BOXES_HEADER = (
    ["ping", "instance", "size_x", "size_y", "size_z"]
    + POSE_COLUMNS
    + ["sonar_" + name for name in POSE_COLUMNS]
)


def rotated(quaternion, vectors):
    """Vectors turned by the quaternion w, x, y, z."""
    w, x, y, z = quaternion
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return vectors @ matrix.T


def corners_of(size, pose):
    """The eight corners of a box whose centre has this pose."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij")).reshape(3, -1).T
    return rotated(pose[3:], signs * size / 2) + pose[:3]


def check_boxes(checklist, sequence):
    """boxes.csv: the boxes of sequence.json carried along with their objects, in both frames."""
    header, rows = sonar_dataset.read_csv(sequence.path("boxes.csv"))
    checklist.expect(header == BOXES_HEADER, f"{sequence.name} boxes.csv header", header, "19 names")
    poses = {
        int(row[0]): np.array(row[2:], float)
        for row in sonar_dataset.read_csv(sequence.path("poses.csv"))[1]
    }
    objects = {
        (int(row[0]), int(row[1])): np.array(row[2:], float)
        for row in sonar_dataset.read_csv(sequence.path("objects.csv"))[1]
    }
    described = {i: e.box for i, e in sequence.instances.items() if e.box}
    wanted = [(ping, i) for ping in sequence.pings for i in sorted(described)]
    found = [(int(row[0]), int(row[1])) for row in rows]
    checklist.expect(
        found == wanted, f"{sequence.name} boxes.csv rows", len(found), "one for each box and ping"
    )
    largest, outside = 0.0, []
    rest = np.array([0, 0, 0, 1, 0, 0, 0], float)
    for row in rows if found == wanted else []:
        ping, instance = int(row[0]), int(row[1])
        size, world, sonar = np.split(np.array(row[2:], float), [3, 10])
        box = described[instance]
        own = corners_of(box["size_m"], np.array(box["centre_m"] + box["quaternion_wxyz"]))
        frame = objects.get((ping, instance), rest)
        expected = rotated(frame[3:], own) + frame[:3]
        seen = rotated(poses[ping][3:], corners_of(size, sonar)) + poses[ping][:3]
        gaps = np.abs(np.stack([corners_of(size, world), seen]) - expected)
        largest = max(largest, float(gaps.max() / (1 + np.abs(expected).max())))
        if sequence.has("scatterers"):
            echoes = sequence.scatterers(ping)
            echoes = echoes[echoes["instance"] == instance]
            places = np.stack([echoes[axis] for axis in "xyz"], axis=-1) - world[:3]
            inside = np.abs(rotated(world[3:] * [1, -1, -1, -1], places)) <= size / 2 + 1e-3
            outside += [(ping, instance)] * (not inside.all())
    checklist.expect(
        largest < 1e-9, f"{sequence.name} boxes.csv, corners in both frames", largest, 1e-9
    )
    checklist.expect_none(outside, f"{sequence.name} boxes.csv, echoes outside their box")

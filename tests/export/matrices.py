"""Levels and poses of a ping by NumPy alone."""
import numpy as np

from ensonify_dataset import SonarDataset

_open = {}


def ping_of(sequence, ping):
    folder = sequence.folder.parents[1]
    if folder not in _open:
        _open[folder] = SonarDataset(folder)
    return _open[folder][sequence.number, ping]


def level_db(sequence, ping):
    """[samples, beams]."""
    return np.asarray(ping_of(sequence, ping).polar.level_db, dtype=np.float64)


def of_pose(pose):
    """4 x 4, from x, y, z, qw, qx, qy, qz: Rodrigues' formula, without the program's rotation of vectors."""
    x, y, z, w, i, j, k = pose
    cross = np.array([[0, -k, j], [k, 0, -i], [-j, i, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += 2 * w * cross + 2 * cross @ cross
    matrix[:3, 3] = x, y, z
    return matrix



"""A data set with a camera that passes a small ball, and where the ball is in its images."""
import numpy as np

import exported

SCENARIO = """ensonify: 1
name: camera
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  beams: {{count: 8, fov_deg: 60}}
  rays: {{elevation: 6, min_per_cell: 0}}
  mount: {{position_m: [0.1, 0, 0.05], rotation_deg: [0, 5, 0]}}
camera:
  mount: {{position_m: [0, 0.2, -0.1], rotation_deg: [4, -6, 3]}}
  width_px: 640
  height_px: 480
  focal_px: [600, 620]
  {distortion}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - {{name: ball, class: ball, material: m, shape: {{sphere: {{radius_m: 0.06}}}}, pose: {{position_m: [3, 0.4, 0.3]}}}}
trajectory:
  poses: [{{time_s: 1, position_m: [0, 0, 0]}}, {{time_s: 2, position_m: [0.3, 0.2, 0.1], rotation_deg: [0, 5, 10]}}]
  ping_rate_hz: 2
  pings: 3
output: {{polar: false, cartesian: false, png: false, timeseries: none}}
"""
BALL = np.array([3, 0.4, 0.3])
RADIUS_M = 0.06
DISTORTION = {"k1": -0.2, "k2": 0.06, "p1": 0.002, "p2": -0.001, "k3": 0.01}


def dataset(**distortion):
    text = "distortion: {" + ", ".join(f"{key}: {value}" for key, value in distortion.items()) + "}"
    return exported.made(SCENARIO.format(distortion=text if distortion else ""))


def middle_of_ball(sequence, ping):
    """[column, row] of the ball's mask, 0 at the center of the first pixel."""
    rows, columns = np.nonzero(sequence.png("camera", ping, "_instance") == 1)
    assert len(rows) > 100
    return np.array([columns.mean(), rows.mean()])


def middle_of_outline(x, y, z):
    """Where the ellipse is centered that a ball at this place shows at distance 1, before any distortion."""
    return np.array([x, y]) * z / (z**2 - RADIUS_M**2)


def distorted(x, y, k1, k2, p1, p2, k3):
    """As the documentation of cv2.calibrateCamera writes it."""
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2),
            y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y)

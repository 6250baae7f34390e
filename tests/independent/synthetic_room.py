"""What check_trace.py reads of a data set of turning_room.yaml, made by our own tracer."""
import json

import numpy as np

import check_trace
import synthetic_tank
from check_scatterers import FIELDS
from pulses import Pulse
from ray_tracer import rotation_from_degrees
from sequence import Sonar
from traced_world import expected_echoes, ray_directions

FOLDER = "sequences/000000"


def make_sonar():
    """The sonar of turning_room.yaml; what the trace does not use is left at plain numbers."""
    return Sonar(
        beams=65,
        spacing_rad=np.radians(100) / 65,
        width_rad=np.radians(3),
        fan_rad=np.radians(40),
        elevation_width_rad=np.radians(15),
        rays_elevation=40,
        rays_azimuth=2,
        frequency_hz=4e5,
        bandwidth_hz=2e4,
        source_pressure_pa_m=1e5,
        range_min_m=0.4,
        range_max_m=8.0,
        sound_speed_m_s=1500.0,
        absorption_db_m=0.1,
        pulse=Pulse(),
        normalization="calibrated",
        noise_level_db=None,
    )


def quaternion(rotation):
    """w, x, y, z of a rotation by less than half a turn."""
    w = np.sqrt(1 + np.trace(rotation)) / 2
    return [
        w,
        (rotation[2, 1] - rotation[1, 2]) / (4 * w),
        (rotation[0, 2] - rotation[2, 0]) / (4 * w),
        (rotation[1, 0] - rotation[0, 1]) / (4 * w),
    ]


def make_scatterers(sonar, position, rotation):
    """Echoes and targets of one pose, with the fields that a trace decides."""
    wanted = expected_echoes(check_trace.WORLD, sonar, position, rotation)
    elevation, directions = ray_directions(sonar)
    mine = np.nonzero(wanted.instance)[0]
    echoes = np.zeros(len(mine), list(FIELDS))
    echoes["delay_s"] = 2 * wanted.range_m[mine] / sonar.sound_speed_m_s
    echoes["azimuth_rad"] = np.arctan2(directions[mine, 1], directions[mine, 0])
    echoes["elevation_rad"] = elevation[mine]
    echoes["instance"], echoes["cos_incidence"] = wanted.instance[mine], wanted.cosine[mine]
    echoes["variance"] = wanted.variance[mine]
    seen = check_trace.expected_targets(sonar, position, rotation)
    targets = np.zeros(len(seen), list(FIELDS))
    for row, (identity, amplitude, range_m, _) in zip(targets, seen):
        row["instance"], row["amp_re"], row["delay_s"] = (
            identity,
            amplitude,
            2 * range_m / sonar.sound_speed_m_s,
        )
    return np.concatenate([echoes, targets])


def write_data_set(root):
    """dataset.json, sequence.json, poses, objects and scatterers."""
    sonar = make_sonar()
    poses, objects = "ping,time_s,x,y,z,qw,qx,qy,qz\n", "ping,instance,x,y,z,qw,qx,qy,qz\n"
    for ping in range(6):
        time_s = check_trace.PATH[0][0] + ping / check_trace.PING_RATE_HZ
        position, rotation = check_trace.expected_pose(time_s)
        numbers = [*position, *quaternion(rotation)]
        poses += ",".join(map(repr, [ping, time_s, *map(float, numbers)])) + "\n"
        for identity in range(1, len(check_trace.WORLD) + len(check_trace.TARGETS) + 1):
            place, turn = check_trace.object_pose(identity)
            numbers = [*place, *quaternion(rotation_from_degrees(*turn))]
            objects += ",".join(map(repr, [ping, identity, *map(float, numbers)])) + "\n"
        synthetic_tank.save_array(
            f"{root}/{FOLDER}/scatterers/{ping:06d}.npy", make_scatterers(sonar, position, rotation)
        )
    info = synthetic_tank.description(sonar, 0, (0.0, 1.0))
    info["sonar"]["range_min_m"], info["sonar"]["range_max_m"] = (
        sonar.range_min_m,
        sonar.range_max_m,
    )
    synthetic_tank.write(f"{root}/{FOLDER}/sequence.json", json.dumps(info))
    synthetic_tank.write(f"{root}/{FOLDER}/poses.csv", poses)
    synthetic_tank.write(f"{root}/{FOLDER}/objects.csv", objects)
    synthetic_tank.write(f"{root}/dataset.json", "{}")

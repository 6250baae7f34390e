"""sonar_netcdf4: structure, beams, poses and levels by h5py, with the equations of the convention."""
import subprocess
import sys
import time
import unittest

import h5py
import numpy as np

import exported
from exported import run, scratch
from sonar_dataset import read_exr

BEAMS = "/Sonar/Beam_group1"
# Mandatory variables of version 2.0 with their dimensions (docs/*.adoc of the convention).
MANDATORY = {
    "/Environment": {"frequency": ["frequency"], "absorption_indicative": ["frequency"],
                     "sound_speed_indicative": []},
    "/Platform": {"transducer_function": ["transducer"], "transducer_ids": ["transducer"],
                  "position_ids": ["position"], "MRU_ids": ["MRU"], "gyro_ids": ["gyro"]},
    "/Platform/Position/pose": {"time": ["time"], "latitude": ["time"], "longitude": ["time"]},
    "/Platform/Attitude/pose": {k: ["time"] for k in ("time", "pitch", "roll", "heading", "vertical_offset")},
    "/Platform/Gyro/pose": {"time": ["time"], "heading": ["time"]},
    "/Provenance": {"source_filenames": ["filenames"]},
    BEAMS: {
        "beam": ["beam"], "frequency": ["frequency"], "beam_type": [], "receive_transducer_index": ["beam"],
        "transducer_gain": ["ping_time", "beam", "frequency"],
        **{k: ["ping_time"] for k in (
            "ping_time", "beam_stabilisation", "non_quantitative_processing", "platform_heading",
            "platform_latitude", "platform_longitude", "platform_pitch", "platform_roll",
            "platform_vertical_offset", "sample_interval", "sound_speed_at_transducer", "time_varied_gain")},
        **{k: ["ping_time", "beam"] for k in (
            "backscatter_r", "backscatter_i", "beamwidth_receive_major", "beamwidth_receive_minor",
            "blanking_interval", "equivalent_beam_angle", "gain_correction", "receiver_sensitivity",
            "rx_beam_rotation_phi", "rx_beam_rotation_psi", "rx_beam_rotation_theta", "sample_count",
            "transmit_beam_index", "beam_direction_x", "beam_direction_y", "beam_direction_z")},
        **{k: ["ping_time", "tx_beam"] for k in (
            "beamwidth_transmit_major", "beamwidth_transmit_minor", "receive_duration_effective",
            "sample_time_offset", "transmit_bandwidth", "transmit_duration_nominal", "transmit_frequency_start",
            "transmit_frequency_stop", "transmit_power", "transmit_source_level", "transmit_transducer_index",
            "transmit_type", "tx_beam_rotation_phi", "tx_beam_rotation_psi", "tx_beam_rotation_theta")}}}

# A point target of -20 dB on the axis of beam 24 of 48, where a sample lies, without noise.
TARGET = """ensonify: 1
name: target
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 30000
  range_max_m: 5
  beams: {count: 49, fov_deg: 49, transmit_width_deg: 60}
  rays: {elevation: 8}
water: {sound_speed_m_s: 1500, absorption: {fixed_db_m: 0.05}}
scattering: {normalization: calibrated}
point_targets: [{name: ball, class: ball, target_strength_db: -20, position_m: [2.954423259, 0.520944533, 0]}]
trajectory: {poses: [{time_s: 0, position_m: [0, 0, 0]}], pings: 1}
"""


def samples(group, ping, beam):
    return group["backscatter_r"][ping][beam] + 1j * group["backscatter_i"][ping][beam]


def ranges(file, group, ping):
    """The range of each sample, as the convention has it."""
    first = group["blanking_interval"][ping, 0] - group["sample_time_offset"][ping, 0]
    times = first + np.arange(group["sample_count"][ping, 0]) * float(group["sample_interval"][ping])
    return float(file["/Environment/sound_speed_indicative"][()]) * times / 2


def target_strengths(file, group, ping, beam):
    """TS of conversion equation type 1; its factor cos(tilt) is 1 for horizontal beams."""
    r = ranges(file, group, ping)
    carrier = (group["transmit_frequency_start"][ping, 0] + group["transmit_frequency_stop"][ping, 0]) / 2
    wavelength = file["/Environment/sound_speed_indicative"][()] / carrier
    alpha = np.interp(carrier, file["/Environment/frequency"][:], file["/Environment/absorption_indicative"][:])
    power = group["transmit_power"][ping, 0]
    with np.errstate(divide="ignore"):
        return (20 * np.log10(np.abs(samples(group, ping, beam))) + 40 * np.log10(r) + 2 * alpha * r
                - 10 * np.log10(power * wavelength**2 / (16 * np.pi**2)) - group["transducer_gain"][ping, beam, 0])


class SonarNetcdf4(exported.Case):
    format_name = "sonar_netcdf4"

    def files(self, source=None):
        out = exported.export("sonar_netcdf4", source=source)
        for sequence in exported.sequences(source):
            with h5py.File(out / f"{sequence.number:06}.nc") as file:
                yield sequence, file, file[BEAMS]

    def test_no_times_are_written(self):
        first = exported.hashes(exported.export("sonar_netcdf4"))
        time.sleep(1.1)
        self.assertEqual(exported.hashes(exported.export("sonar_netcdf4")), first)

    def test_groups_variables_and_dimensions(self):
        for sequence, file, group in self.files():
            self.assertEqual(file.attrs["sonar_convention_name"], b"SONAR-netCDF4")
            self.assertEqual(file.attrs["Conventions"], b"CF-1.7, SONAR-netCDF4-2.0, ACDD-1.3")
            for name, variables in MANDATORY.items():
                for variable, dimensions in variables.items():
                    with self.subTest(variable=f"{name}/{variable}"):
                        found = file[f"{name}/{variable}"]
                        self.assertEqual(found.ndim, len(dimensions))
                        is_scale = h5py.h5ds.is_scale(found.id)
                        if not is_scale:
                            self.assertEqual([d[0].name for d in found.dims], [f"{name}/{d}" for d in dimensions])
                        if is_scale or variable.endswith("_ids") or not found.dtype.isbuiltin:
                            continue
                        self.assertIn("units" if "flag_values" not in found.attrs else "long_name", found.attrs)
            # Readers take the equation from an enumeration, and rows from a named type.
            self.assertEqual(group.attrs["conversion_equation_type"].tolist(), [1])
            kind = group.attrs.get_id("conversion_equation_type").dtype
            self.assertEqual(h5py.check_enum_dtype(kind)["type_1"], 1)
            for name in ("backscatter_r", "backscatter_i", "time_varied_gain"):
                stored = group[name].id.get_type()
                self.assertTrue(stored.committed(), name)
                self.assertTrue(stored.equal(group["sample_t"].id), name)
            self.assertEqual(group["transmit_type"][0, 0], 0)

    def test_samples_are_the_time_series(self):
        for sequence, file, group in self.files():
            self.assertEqual([name.decode() for name in group["beam"]], [str(j) for j in range(48)])
            for row, ping in enumerate(sequence.pings):
                series = sequence.npy(f"timeseries/{ping:06}.npy")
                for beam in range(len(series)):
                    self.assertEqual(samples(group, row, beam).astype("c8").tobytes(), series[beam].tobytes())
                np.testing.assert_array_equal(group["sample_count"][row], series.shape[1])
                self.assertEqual(group["time_varied_gain"][row].tolist(), [0] * series.shape[1])
                self.assertEqual(file["/Provenance/source_filenames"][row].decode(),
                                 f"sequences/{sequence.number:06}/timeseries/{ping:06}.npy")

    def test_levels_and_ranges(self):
        """20 lg|backscatter| less the sensitivity is the level; TS is what the sonar equation makes of it.

        EXR files have steps of 1/8 dB at most, so that the level is off by up to 1/16 dB; float32 takes 1e-4 dB.
        """
        for sequence, file, group in self.files():
            own_range = sequence.npy("range_m.npy")
            head = sequence.head
            alpha = head["water"]["absorption_db_m"]
            for row, ping in enumerate(sequence.pings):
                stored = read_exr(sequence.folder / f"polar/{ping:06}.exr")[0].channels["Y"].astype(float)
                np.testing.assert_allclose(ranges(file, group, row), own_range, rtol=1e-6)
                for beam in range(0, 48, 5):
                    with np.errstate(divide="ignore"):
                        level = 20 * np.log10(np.abs(samples(group, row, beam)))
                        own = level + 120 - head["sonar"]["source_level_db"] + 40 * np.log10(own_range)
                    level -= group["receiver_sensitivity"][row, beam] + group["gain_correction"][row, beam]
                    echo = stored[:, beam] > -99
                    np.testing.assert_allclose(level[echo], stored[echo, beam], atol=1 / 16 + 1e-4)
                    strength = target_strengths(file, group, row, beam)
                    np.testing.assert_allclose(strength[1:], (own + 2 * alpha * own_range)[1:], atol=1e-4)

    def test_beams(self):
        for sequence, file, group in self.files():
            azimuth, head = sequence.npy("azimuth_rad.npy"), sequence.head["sonar"]
            for row in range(len(sequence.pings)):
                x, y, z = (group[f"beam_direction_{k}"][row].astype(float) for k in "xyz")
                np.testing.assert_allclose(np.arctan2(-y, x), azimuth, atol=1e-6)
                np.testing.assert_array_equal(z, 0)
                # Rz(psi) Ry(theta) Rx(phi), applied to the axis of the beam.
                phi, theta, psi = (np.radians(group[f"rx_beam_rotation_{k}"][row].astype(float))
                                   for k in ("phi", "theta", "psi"))
                np.testing.assert_array_equal(psi, 0)
                axis = np.stack([np.cos(phi) * np.sin(theta), -np.sin(phi), np.cos(phi) * np.cos(theta)])
                np.testing.assert_allclose(axis, [x, y, z], atol=1e-6)
                np.testing.assert_allclose(group["receive_duration_effective"][row],
                                           exported.gaussian_pulse_s(head["bandwidth_hz"]), rtol=1e-4)
                np.testing.assert_allclose(group["beamwidth_receive_major"][row],
                                           np.degrees(head["beams"]["width_rad"]), rtol=1e-6)
            # The two-way pattern sinc(0.884 sin(phi)/w) is one half, and the one-way power too, at 0.6034/0.884 w.
            width = 2 * np.arcsin(0.60335458 / 0.884 * head["elevation"]["width_rad"])
            np.testing.assert_allclose(group["beamwidth_receive_minor"][:], np.degrees(width), rtol=1e-4)
            np.testing.assert_allclose(group["equivalent_beam_angle"][:], self.beam_angle(head), rtol=1e-3)

    @staticmethod
    def beam_angle(sonar):
        """The integral of sinc^2(0.884 sin(theta)/w) in azimuth, and in elevation with cos(phi)."""
        angle, step = np.linspace(-np.pi / 2, np.pi / 2, 200_001, retstep=True)
        azimuth, elevation = (np.sinc(0.884 * np.sin(angle) / sonar[k]["width_rad"]) ** 2 for k in ("beams", "elevation"))
        return azimuth.sum() * step * (elevation * np.cos(angle)).sum() * step

    def test_pings(self):
        for sequence, file, group in self.files():
            for row, ping in enumerate(sequence.pings):
                time_ns = round(float(sequence.poses[ping]["time_s"]) * 1e9)
                position, attitude = file["/Platform/Position/pose"], file["/Platform/Attitude/pose"]
                for times in (group["ping_time"], position["time"], attitude["time"], file["/Platform/Gyro/pose/time"]):
                    self.assertEqual(times[row], time_ns)
                    self.assertEqual(times.attrs["units"], b"nanoseconds since 1970-01-01 00:00:00Z")
                pose = sequence.pose(ping)
                self.assertEqual([position[f"local_{k}"][row] for k in "xyz"], pose[:3])
                self.assertTrue(np.isnan(position["latitude"][row]) and np.isnan(group["platform_longitude"][row]))
                self.assertTrue(np.isnan(position["latitude"].attrs["_FillValue"]))
                h, p, r = (np.radians(float(attitude[k][row])) for k in ("heading", "pitch", "roll"))
                np.testing.assert_allclose(self.rotation(h, p, r), self.nautical(pose[3:]), atol=1e-6)
                for name in ("heading", "pitch", "roll"):
                    self.assertEqual(group[f"platform_{name}"][row], attitude[name][row])

    @staticmethod
    def rotation(h, p, r):
        """Rz(h) Ry(p) Rx(r) of the convention: platform to north, east, down."""
        rz = np.array([[np.cos(h), -np.sin(h), 0], [np.sin(h), np.cos(h), 0], [0, 0, 1]])
        ry = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
        rx = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
        return rz @ ry @ rx

    @staticmethod
    def nautical(quaternion):
        """The pose's rotation, between axes ahead, starboard, down and north, east, down."""
        w, x, y, z = quaternion
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        return np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ turn @ np.diag([1, -1, -1])

    def test_a_point_target_has_its_strength(self):
        """Equation type 1 gives -20 dB, also where the transmit pattern is below 1."""
        folder = scratch()
        (folder / "target.yaml").write_text(TARGET)
        made = run("generate", folder / "target.yaml", "-o", folder / "set", "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        for sequence, file, group in self.files(folder / "set"):
            beam = int(np.argmin(np.abs(sequence.npy("azimuth_rad.npy") - np.radians(10))))
            strength = target_strengths(file, group, 0, beam)
            self.assertEqual(int(np.argmax(np.abs(samples(group, 0, beam)))), 120)
            self.assertAlmostEqual(strength[120], -20, delta=0.02)
            self.assertEqual(group["non_quantitative_processing"][0], 0)

    def test_without_time_series_the_key_is_named(self):
        recording = scratch() / "recording"
        made = run("import", exported.export("oculus") / "000000.oculus", "-o", recording, "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        without = exported.dataset("--set", "output={timeseries: none}")
        for source, advice in ((without, "output.timeseries"), (recording, "a recording, which lacks")):
            result = run("export", source, "--format", "sonar_netcdf4", "-o", scratch() / "out")
            self.assertEqual(result.returncode, 2)
            self.assertIn(advice, result.stderr)

    def test_time_series_of_exr_files(self):
        source = exported.dataset("--set", "output.timeseries=exr")
        for (_, file, group), (_, _, other) in zip(self.files(source), self.files()):
            for beam in range(48):
                self.assertEqual(samples(group, 0, beam).tobytes(), samples(other, 0, beam).tobytes())
            self.assertTrue(file["/Provenance/source_filenames"][0].endswith(b"000000.exr"))

    def test_beams_outside_of_the_transmit_main_lobe_have_numbers(self):
        """20 degrees wide: zeros near 23 degrees, negative side lobes beyond."""
        source = exported.dataset("--set", "sonar.beams={count: 45, fov_deg: 90, transmit_width_deg: 20}",
                                  "--set", "sonar.rays.elevation=1")
        with h5py.File(next(exported.export("sonar_netcdf4", source=source).glob("*.nc"))) as file:
            for name in ("transducer_gain", "equivalent_beam_angle"):
                self.assertTrue(np.isfinite(file[f"{BEAMS}/{name}"][:]).all(), name)

    def test_beams_of_arrays_widen_with_the_azimuth(self):
        source = exported.dataset(
            "--set", "sonar.beams={count: 41, fov_deg: 82, receive_width_deg: 1}",
            "--set", "sonar.receiver={mode: array}", "--set", "sonar.rays.elevation=1")
        with h5py.File(next(exported.export("sonar_netcdf4", source=source).glob("*.nc"))) as file:
            width = file[f"{BEAMS}/beamwidth_receive_major"][0].astype(float)
            angle = file[f"{BEAMS}/equivalent_beam_angle"][0].astype(float)
            azimuth = np.arctan2(*(file[f"{BEAMS}/beam_direction_{k}"][0].astype(float) for k in "yx"))
        np.testing.assert_allclose(width * np.cos(azimuth), width[20], rtol=1e-5)
        np.testing.assert_allclose((angle * np.cos(azimuth))[5:36], angle[20], rtol=0.02)

    def test_memory_does_not_grow_with_pings(self):
        peaks_kib = []
        for pings in (2, 21):
            source = exported.dataset("--set", f"trajectory.pings={pings}", "--set", "trajectory.ping_rate_hz=40",
                                      "--set", "sequences=1",
                                      "--set", "sonar.beams.count=768", "--set", "sonar.rays.elevation=1",
                                      "--set", "output={polar: false, cartesian: false, png: false}")
            # From a small interpreter, since the peak of a child counts what its parent held.
            code = ("import resource, subprocess, sys\n"
                    "subprocess.run(sys.argv[1:], check=True)\n"
                    "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n")
            peak_kib = subprocess.run([sys.executable, "-S", "-c", code, exported.PROGRAM, "export", str(source),
                                       "--format", "sonar_netcdf4", "-o", str(scratch() / "out"), "--quiet"],
                                      capture_output=True, text=True, check=True).stdout
            peaks_kib.append(int(peak_kib))
        # 19 pings more are 23 MB of samples.
        self.assertLess(peaks_kib[1] - peaks_kib[0], 10_000)


if __name__ == "__main__":
    unittest.main()

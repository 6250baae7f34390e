"""The jobs whose costs the ledger holds, and their rows."""
import concurrent.futures

import counted

TINY = """ensonify: 1
sonar: {preset: blueview_p900_90, range_max_m: 5, beams: {count: 16}}
point_targets: [{name: ball, target_strength_db: -30, position_m: [3, 0, 0]}]
"""
# Three sonars over one world, which costs more than the pings of one of them.
RIG_SONAR = "range_max_m: 4, beams: {count: 8, fov_deg: 8}, rays: {elevation: 40}"
RIG = f"""ensonify: 1
rig:
  - {{name: high, sonar: {{preset: blueview_p900_90, {RIG_SONAR}}}}}
  - {{name: low, sonar: {{preset: blueview_m450_90, {RIG_SONAR}}}}}
  - {{name: side, sonar: {{preset: blueview_p900_90, {RIG_SONAR}, mount: {{position_m: [0, 0.5, 0]}}}}}}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - name: sand
    material: m
    shape: {{heightfield: {{size_m: [20, 20], cell_m: 0.15,
                            roughness: {{rms_m: 0.05, exponent: 3.3, outer_scale_m: 4}}}}}}
    pose: {{position_m: [0, 0, -1]}}
trajectory: {{pings: 2}}
output: {{cartesian: false, png: false}}
"""
SWEEP = """ensonify_sweep: 1
name: tiny
base: tiny.yaml
axes:
  - {key: sonar.range_max_m, values: [3, 5]}
  - {key: noise.spectrum_level_db, linear: [20, 40], count: 3}
"""
PYTHON = """
import sys
import ensonify
scene = ensonify.Scenario.load(sys.argv[1], set={"sonar.beams.count": 16, "sonar.range_max_m": 7})
print(scene.ping().polar.level_db.mean())
"""
# Small sonars, and display limits where finding them would take longer than the pings. Together they reach every stage:
# a tank as the paper has it; a sampled world on synthetic terrain; an array over mirrors, with signal components; and a
# moving sonar with growth, bounces and volumes, and every kind of label.
LIMITS = "png: {db: [60, 120]}, cartesian: {height_px: 200}"
SCENES = {
    "tank": ["sonar_tank.yaml", "0:3", "--set", "sonar.beams.count=16", "--set", "sonar.range_max_m=7"],
    "debris": ["random_debris.yaml", "0:1", "--set", "sequences=1",
               "--set", "sonar.beams.count=24", "--set", f"output={{{LIMITS}}}"],
    "array": ["shallow_water.yaml", "0:1", "--set", "sonar.beams.count=16",
              "--set", "sonar.rays.elevation=100", "--set", "sonar.receiver={mode: array, elements: 12}",
              "--set", f"output={{layers: true, {LIMITS}}}"],
    "pile": ["pile_inspection.yaml", "0:1", "--set", "sonar.beams.count=16", "--set", "bounces=1",
             "--set", "volumes=[{name: murk, class: water, uniform: {strength_db: -75}}]",
             "--set", "output={surfaces: true, motion: true, front: true, elevation: true, points: true, "
                      f"polygons: true, one_file_per: sequence, {LIMITS}}}"],
}
# The functions that are the stages of core/stage_times.h, and what precedes the first ping. One may contain another.
STAGES = {
    "open": ["SequenceWorlds::open_untraced("],
    "world": ["prepare_session(", "Tracer::Tracer("],
    "tables": ["pipeline_tables("],
    "trace": ["trace_fan("],
    "scatterers": ["adaptive_surface_scatterers(", "kirchhoff_scatterers(", "bounced_off_surfaces(", "volume_echoes("],
    "hidden": ["trace_behind(ensonify::Tracer", "hidden_echoes("],
    "synthesis": ["received_series(", "received_layers("],
    "labels": ["polar_image(", "add_surfaces(", "add_motion(", "elevation_echoes("],
    "shadow": ["hidden_labels("],
    "annotations": ["instance_runs(", "annotations(", "instance_measures(", "add_amodal("],
    "cartesian": ["resample("],
    "grey": ["displayed(", "displayed_cartesian("],
    "encode": ["encode_ping("],
    "hash": ["sha256_hex["],
    "record": ["record_of("],
    "store": ["store_ping(", "finish_sequence(", "finish_work("],
}
# What a ping calls as well: little things, what runs once a sequence, what a function above calls back, and echoes that
# no scene above has. A function that a scene reaches and that takes time belongs above.
UNCOUNTED = """
absorb attenuate both_ways_as_one bounced_echoes can_shift cartesian_gains detected_levels_db display_table echo_levels
edge_scatterers elastic_scatterers fan_of_group first_return_m front_end front_view group_levels_db hears_echo
make_surface_scattering more_absorption_db_m move_echoes movement_of point_motions point_target_scatterers pose_in
record_ping rests school_scatterers shift_carriers surface_normals surface_point_list surface_scatterer_list
volume_elevation_echoes
""".split()
FIXED = ["--threads", "1", "--simd", "avx2", "--backend", "cpu"]


def generate(program, root, scene, folder, pings=None):
    """Without the look at the free space, which measures a ping where little is free."""
    file, its_pings, *options = SCENES[scene]
    return [program, "generate", root / "scenes" / file, "--pings", pings or its_pings, *options, *FIXED, "--quiet",
            "--ignore-free-space", "-o", folder]


def prepare(place, program, root):
    """What the jobs read: scenarios, two data sets, and Python's compiled modules."""
    (place.folder / "tiny.yaml").write_text(TINY)
    (place.folder / "sweep.yaml").write_text(SWEEP)
    (place.folder / "rig.yaml").write_text(RIG)
    place.run(generate(program, root, "tank", "one"))
    place.run([*generate(program, root, "tank", "other"), "--seed", "5"])


def commands(build, root):
    """{name: command} of the jobs whose instructions are counted as a whole."""
    program = build / "ensonify"
    return {
        "version": [program, "--version"],
        "check_tiny": [program, "check", "tiny.yaml", *FIXED],
        "export_netcdf": [program, "export", "one", "--format", "sonar_netcdf4", "-o", "netcdf", "--quiet"],
        "export_coco": [program, "export", "one", "--format", "coco", "-o", "coco", "--quiet"],
        "report": [program, "report", "one", "-o", "report.html", "--threads", "1", "--quiet"],
        "compare": [program, "compare", "one", "other", "--blocks", "2", "--threads", "1", "--quiet"],
        "sweep_plan": [program, "sweep", "--list", "--shard", "0/1", "sweep.yaml"],
        "generate_rig": [program, "generate", "rig.yaml", *FIXED, "--quiet", "--ignore-free-space", "-o", "rig"],
        "python_ping": ["/usr/bin/python3", "-c", PYTHON, root / "scenes/sonar_tank.yaml"],
    }


def stage_rows(scene, measured):
    total, counts = measured
    rows = {f"instructions.generate_{scene}": total}
    for stage, functions in STAGES.items():
        count = sum(counts.get(function, 0) for function in functions)
        if count:
            rows[f"stage.{scene}.{stage}"] = count
    return rows


def instruction_rows(place, build, root):
    functions = [function for stage in STAGES.values() for function in stage]
    jobs, program = commands(build, root), build / "ensonify"
    place.run(jobs["python_ping"])  # compiles modules
    with concurrent.futures.ThreadPoolExecutor(2) as pool:  # the longest first
        scenes = {scene: pool.submit(counted.stages, place, scene, generate(program, root, scene, scene), functions)
                  for scene in SCENES}
        others = {name: pool.submit(counted.instructions, place, words) for name, words in jobs.items()}
    measured = {scene: job.result() for scene, job in scenes.items()}
    for function in functions:
        if not any(function in counts for _, counts in measured.values()):
            raise RuntimeError(f"no scene calls ensonify::{function}: it was renamed or inlined; put the function that "
                               "does its work now into STAGES of tests/ledger/jobs.py")
    rows = {f"instructions.{name}": job.result() for name, job in others.items()}
    for scene in SCENES:
        rows.update(stage_rows(scene, measured[scene]))
    return rows


def byte_rows(place, build, root):
    """Of a further ping of a data set with the files that a scenario gets without `output`, over four."""
    few, more = (counted.bytes_of(place, generate(build / "ensonify", root, "tank", f"bytes_{pings}", f"0:{pings}"))
                 for pings in (2, 6))
    if not more["hashed"] or not more["written"]:
        raise RuntimeError(f"counted {more}: the program hashes without EVP_DigestUpdate of libcrypto, or this system "
                           "has no /proc/self/io; see tests/ledger/counts.cpp")
    return {f"bytes.{name}": (more[name] - few[name]) // 4 for name in few}


def memory_rows(place, build, root):
    program = build / "ensonify"
    return {"memory.check_tiny": counted.peak_kb(place, [program, "check", "tiny.yaml", *FIXED]),
            "memory.generate_pile": counted.peak_kb(place, generate(program, root, "pile", "memory"))}


def start_rows(place, build, root):
    return {f"start.{name}": value for name, value in counted.start(place, [build / "ensonify", "--version"]).items()}


ROWS = {"start": start_rows, "bytes": byte_rows, "memory": memory_rows, "instructions": instruction_rows}

#!/usr/bin/env python3
"""Fills the tables of docs/performance.md from the file that `ensonify bench --json FILE` or scripts/gpu_check.sh wrote.

    scripts/make_performance.py BENCH.json
    scripts/make_performance.py build/gpu_check.json
    scripts/make_performance.py BENCH.json --machine "AMD EPYC 9354"

A table keeps its numbers if the file has not all for it, as after `bench --only series`.
"""
import argparse
import json
import pathlib
import re

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs/performance.md"
BLOCK = re.compile(r"(<!-- made by scripts/make_performance.py: (\w+) -->\n).*?(<!-- end of what is made -->)", re.S)

# Descriptions of the kinds of files of `full`, and of the files that the scenes write.
FILES = {
    "series": "time series as NPY, the least", "series_exr": "… and as EXR",
    "polar": "series, polar images, masks, annotations", "polar_shadow": "`polar`, shadow masks",
    "polar_amodal": "`polar`, amodal masks", "polar_polygons": "`polar`, polygons",
    "polar_surfaces": "`polar`, planes of surfaces and layover", "polar_motion": "`polar`, motion to the next ping",
    "front": "series, front views", "elevation": "series, echo power over elevation",
    "cartesian": "as `polar`, Cartesian", "png": "series, 8-bit polar images", "scatterers": "series, scatterers",
    "points": "series, points", "layers": "series, signal components",
    "default": "what a scenario without `output` gives", "default_packed": "… with `one_file_per: sequence`",
    "every": "every file of this scene"}
SCENES = {"random_debris": "default", "wreck_survey": "default", "rippled_seabed": "default",
          "shallow_water": "default, signal components"}
GROWTH = ("threads", "beams", "samples", "rays", "objects", "triangles")
PHYSICS = ("trace", "scatterers", "synthesis")
# What a factor of `features` compares.
PER_PING = ("trace", "scatterers", "hidden", "synthesis", "labels", "shadow")
FEATURES = {
    "plain": "flat floor and a ball, 512 equal beams", "unequal_beams": "`azimuths_deg`",
    "motion_within_ping": "`motion_within_ping`", "array": "`receiver: {mode: array}`",
    "surface_speckle": "`speckle: surface`", "surfaces": "`output: {surfaces: true}`",
    "multipath": "`multipath`, sea surface", "bounces": "`bounces: 1`", "refraction": "`water: {profile}`",
    "layers": "`output: {layers: true}`", "volume": "`volumes`, all the water"}
ENSEMBLE = {"moments": "`speckle_wall`: moments alone", "series": "… and the time series of each realization"}
# Columns of the table of stages, and rows of the table of a device.
STAGES_OF = ("polar", "default", "random_debris", "wreck_survey", "shallow_water")
DEVICE_KINDS = ("series", "polar", "default")
# Stages that stay on the host when a device computes the time series.
HOST = {"rays, scatterers": ("trace", "scatterers", "hidden"), "labels": ("labels", "shadow", "annotations"),
        "resampling": ("cartesian", "grey"), "encoding": ("encode_npy", "encode_exr", "encode_png", "encode_other"),
        "hashing": ("hash",), "records, writing, rest": ("record", "store", "moments", "rest")}


def digits(value):
    """Three digits, or all before the decimal point."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def table(head, rows):
    lines = ["| " + " | ".join(cells) + " |" for cells in [head, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def rows_of(bench, *names):
    """The rows of these tables of the bench, by name; none if one of the tables is missing."""
    tables = [bench.get("tables", {}).get(name) for name in names]
    return {} if None in tables else {name: row for made in tables for name, row in made["rows"].items()}


def data_sets(bench):
    rows = []
    for name, n in rows_of(bench, "files", "scenes").items():
        files = FILES.get(name) or SCENES.get(name, "its own")
        size = f", {n['beams']:.0f} × {n['samples']:.0f}" if name in SCENES else ""
        least, middle, most = (digits(n["pings_per_s" + end]) for end in ("_least", "", "_most"))
        rows.append([f"`{name}`{size}: {files}", f"{middle} ({least}–{most})",
                     f"{float('%.3g' % (3600 * n['pings_per_s'])):,.0f}", digits(n["core_ms_per_ping"]),
                     digits(n["mb_per_ping"]), f"{100 * n['physics_share']:.0f}%"])
    return table(["files", "pings/s (range)", "images/h", "core ms/ping", "MB/ping", "physics"], rows) if rows else None


def stages(bench):
    measured = rows_of(bench, "files", "scenes")
    columns = {name: measured[name]["stages_ms"] for name in STAGES_OF if name in measured}
    names = list(next(iter(columns.values()), {}))
    rows = [[f"`{stage}`", *(digits(ms[stage]) if ms[stage] >= 1e-3 else "–" for ms in columns.values())]
            for stage in names if any(ms[stage] >= 1e-3 for ms in columns.values())]
    return table(["stage", *(f"`{name}`" for name in columns)], rows) if rows else None


def series(bench):
    rows = []
    for name, row in rows_of(bench, "series").items():
        ms = [row["stages_ms"][stage] for stage in PHYSICS]
        rows.append([f"`{name}`", f"{row['beams']:.0f} × {row['rays'] / row['beams']:.0f}", *map(digits, ms),
                     digits(1000 / sum(ms)), f"{row['error']:.1e}, {row['error_worst_tenth']:.1e}"])
    return table(["case", "beams × rays", *(f"`{stage}`" for stage in PHYSICS), "pings/s of a core",
                  "error, worst tenth"], rows) if rows else None


def features(bench):
    measured = {name: [row["stages_ms"][stage] for stage in PER_PING]
                for name, row in rows_of(bench, "features").items()}
    rows = [[FEATURES.get(name, f"`{name}`"), *map(digits, ms), digits(sum(ms) / sum(measured["plain"]))]
            for name, ms in measured.items()]
    return table(["feature", *(f"`{stage}`" for stage in PER_PING), "factor"], rows) if rows else None


def ensemble(bench):
    rows = [[ENSEMBLE.get(name, f"`{name}`"), digits(row["pings_per_s"]),
             *(digits(row["stages_ms"][stage]) for stage in ("synthesis", "moments")), digits(row["core_ms_per_ping"])]
            for name, row in rows_of(bench, "ensemble").items()]
    return table(["what is kept", "realizations/s", "`synthesis`", "`moments`", "core ms"], rows) if rows else None


def growth(bench):
    rows = []
    for name in GROWTH if rows_of(bench, *GROWTH) else ():
        points, core = bench["tables"][name]["rows"].values(), bench["tables"][name]["exponents"]["core"]
        each = [" → ".join(digits(point[key]) for point in points) for key in (name, "pings_per_s")]
        rows.append([name, *each, ", ".join("–" if k is None else f"{k:.2f}" for k in (core["all"], core["last_two"]))])
    return table(["size", "values", "pings/s", "exponent: all, last two"], rows) if rows else None


def device(bench):
    kinds = rows_of(bench, "files")
    rows = []
    for kind in (name for name in DEVICE_KINDS if name in kinds):
        parts = [sum(kinds[kind]["stages_ms"].get(stage, 0) for stage in group) for group in HOST.values()]
        rows.append([f"`{kind}`", *map(digits, [*parts, sum(parts), sum(parts) / 10, kinds[kind]["mb_per_ping"] / 10])])
    return table(["files", *HOST, "total", "cores for 100 pings/s", "GB/s for 100 pings/s"],
                 rows) if rows else None


def gpu(check):
    if not check.get("figures"):
        return None
    m, rows = check["machine"], []
    for figure in check["figures"].values():
        value = "not measured" if figure["met"] is None else f"{digits(figure['value'])} {figure['unit']}".strip()
        wanted = f"{'≥' if figure['at_least'] else '≤'} {figure['wanted']:,g}"
        rows.append([figure["what"], wanted, value, {True: "yes", False: "no", None: "–"}[figure["met"]]])
    return (f"{m['device']}, driver {m['driver']}, CUDA {m['toolkit']}, {m['threads']} threads of {m['processor']}:\n\n"
            + table(["figure", "wanted", "measured", "met"], rows))


def processor():
    found = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return found.group(1).strip() if found else "unknown processor"


def filled(page, bench, machine):
    """The page with every table for which `bench` has numbers."""
    m = bench["machine"]
    made = {make.__name__: make(bench) for make in (data_sets, stages, series, features, ensemble, growth, device,
                                                       gpu)}
    if made["data_sets"]:
        simd = {"avx512": "AVX-512", "avx2": "AVX2", "sse4": "SSE 4.2"}.get(m["simd"], m["simd"])
        made["machine"] = (f"{m['threads']} threads of {machine}, {simd}; one core copies {m['copy_gb_s']:.1f} "
                           f"GB/s; disk {m['disk_mb_s']:.0f} MB/s.")
    return BLOCK.sub(lambda old: old[1] + made[old[2]] + "\n" + old[3] if made.get(old[2]) else old[0], page)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", type=pathlib.Path, help="what `ensonify bench --json FILE` or gpu_check.sh wrote")
    parser.add_argument("--machine", default=processor(), help="the processor of the run; this machine's by default")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="the page to fill")
    arguments = parser.parse_args()
    bench = json.loads(arguments.bench.read_text(encoding="utf-8"))
    page = arguments.page.read_text(encoding="utf-8")
    arguments.page.write_text(filled(page, bench, arguments.machine), encoding="utf-8")


if __name__ == "__main__":
    main()

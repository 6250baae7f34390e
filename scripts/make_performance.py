#!/usr/bin/env python3
"""Fills the tables of docs/performance.md from the file that `ensonify bench --json FILE` wrote.

    scripts/make_performance.py BENCH.json
    scripts/make_performance.py BENCH.json --machine "AMD EPYC 9354"

A table keeps its numbers if the file has none for it, as after `bench --only stages`.
"""
import argparse
import json
import pathlib
import re

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs/performance.md"
BLOCK = re.compile(r"(<!-- made by scripts/make_performance.py: (\w+) -->\n).*?(<!-- end of what is made -->)", re.S)

# Descriptions of the kinds of files of the data set `full`, and of the files that the scenes write.
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
# Columns of the table of stages, and rows of the table of a device.
STAGES_OF_FULL, STAGES_OF_SCENES = ("polar", "default"), ("random_debris", "wreck_survey", "shallow_water")
DEVICE_KINDS = ("series", "polar", "default")
# Stages that stay on the host when a device computes the time series.
HOST = {"rays, scatterers": ("trace", "scatterers", "hidden"), "labels": ("labels", "shadow", "annotations"),
        "resampling": ("cartesian", "grey"), "encoding": ("encode_npy", "encode_exr", "encode_png", "encode_other"),
        "hashing": ("hash",), "records, writing, rest": ("record", "store", "rest")}


def digits(value):
    """Three digits, or all before the decimal point."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def table(head, rows):
    lines = ["| " + " | ".join(cells) + " |" for cells in [head, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def kinds_of(bench):
    """(data set, kind of files, its numbers)"""
    return [(name, kind, numbers) for name, data_set in bench["data_sets"].items()
            for kind, numbers in data_set["kinds"].items()]


def data_sets(bench):
    rows = []
    for name, kind, n in kinds_of(bench):
        size = "{beams} × {samples}".format(**bench["data_sets"][name])
        scene = f"`{name}`, {size}: {SCENES.get(name, 'its own')}"
        least, middle, most = (digits(n["pings_per_s" + end]) for end in ("_least", "", "_most"))
        rows.append([f"`{kind}`: {FILES.get(kind, '')}" if name == "full" else scene, f"{middle} ({least}–{most})",
                     f"{float('%.3g' % (3600 * n['pings_per_s'])):,.0f}", digits(n["core_ms_per_ping"]),
                     digits(n["mb_per_ping"]), f"{100 * n['physics_share']:.0f}%"])
    return table(["files", "pings/s (range)", "images/h", "core ms/ping", "MB/ping", "physics"], rows) if rows else None


def stages(bench):
    columns = {kind if name == "full" else name: numbers["stages_ms"] for name, kind, numbers in kinds_of(bench)
               if (kind in STAGES_OF_FULL if name == "full" else name in STAGES_OF_SCENES)}
    names = list(next(iter(columns.values()), {}))
    rows = [[f"`{stage}`", *(digits(ms[stage]) if ms[stage] >= 1e-3 else "–" for ms in columns.values())]
            for stage in names if any(ms[stage] >= 1e-3 for ms in columns.values())]
    return table(["stage", *(f"`{name}`" for name in columns)], rows) if rows else None


def cases(bench):
    speeds = ("pings_per_s", "pings_per_s_1_thread", "pings_per_s_with_clean", "speedup_over_direct",
              "speedup_over_recurrence")
    rows = [[f"`{name}`", f"{c['beams']} × {c['rays_per_beam']}", *(digits(c[key]) for key in speeds),
             f"{c['error']:.1e}, {c['error_worst_tenth']:.1e}"] for name, c in bench["cases"].items()]
    return table(["case", "beams × rays", "pings/s", "1 thread", "with expected power", "over direct",
                  "over recurrence", "error, worst tenth"], rows) if rows else None


def growth(bench):
    rows = []
    for name, g in bench["growth"].items():
        each = [" → ".join(digits(point[key]) for point in g["points"]) for key in ("value", "pings_per_s")]
        exponents = [g["core_time_exponent"], g["core_time_exponent_at_end"]]
        rows.append([name, *each, ", ".join("–" if k is None else f"{k:.2f}" for k in exponents)])
    return table(["size", "values", "pings/s", "exponent: all, last two"], rows) if rows else None


def device(bench):
    kinds = bench["data_sets"].get("full", {}).get("kinds", {})
    rows = []
    for kind in (name for name in DEVICE_KINDS if name in kinds):
        parts = [sum(kinds[kind]["stages_ms"].get(stage, 0) for stage in group) for group in HOST.values()]
        rows.append([f"`{kind}`", *map(digits, [*parts, sum(parts), sum(parts) / 10, kinds[kind]["mb_per_ping"] / 10])])
    return table(["files", *HOST, "total", "cores for 100 pings/s", "GB/s for 100 pings/s"],
                 rows) if rows else None


def processor():
    found = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return found.group(1).strip() if found else "unknown processor"


def filled(page, bench, machine):
    """The page with every table for which `bench` has numbers."""
    m = bench["machine"]
    made = {make.__name__: make(bench) for make in (data_sets, stages, cases, growth, device)}
    if made["data_sets"]:
        simd = {"avx512": "AVX-512", "avx2": "AVX2", "sse4": "SSE 4.2"}.get(m["simd"], m["simd"])
        made["machine"] = (f"{m['threads']} threads of {machine}, {simd}; one core: {m['fma_gflops']:.0f} GFlop/s, "
                           f"copies {m['copy_gb_s']:.1f} GB/s; disk {m['disk_mb_s']:.0f} MB/s.")
    return BLOCK.sub(lambda old: old[1] + made[old[2]] + "\n" + old[3] if made.get(old[2]) else old[0], page)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", type=pathlib.Path, help="what `ensonify bench --json FILE` wrote")
    parser.add_argument("--machine", default=processor(), help="the processor of the run; this machine's by default")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="the page to fill")
    arguments = parser.parse_args()
    bench = json.loads(arguments.bench.read_text(encoding="utf-8"))
    page = arguments.page.read_text(encoding="utf-8")
    arguments.page.write_text(filled(page, bench, arguments.machine), encoding="utf-8")


if __name__ == "__main__":
    main()

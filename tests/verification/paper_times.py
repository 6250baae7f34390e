"""Table 2: run times of `ensonify bench` beside those of the paper."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import textwrap

CASES = ("full", "table1", "reduced")
BEGIN, END = "<!-- times -->", "<!-- end of times -->"
# Stages of the paper, their time on its device, and the stages of ours that do the same work.
STAGES = (
    ("rays", "0.3 s", ("trace", "scatterers")),
    ("summation over echoes, correction (Eq 16), transforms", "1.34 s", ("synthesis",)),
)


def measured(program):
    """The JSON of the bench of time series, and how busy the machine was before."""
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="ensonify-") as folder:
        place = pathlib.Path(folder) / "bench.json"
        subprocess.run(
            [program, "bench", "--only", "series", "--json", str(place), "--disk", folder],
            check=True,
            capture_output=True,
        )
        return json.loads(place.read_text(encoding="utf-8")), load


def processor():
    """Name of the processor, without what marks and clocks add to it."""
    found = re.search(
        r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    )
    name = found.group(1) if found else "unknown"
    return re.sub(r"\s*(\((R|TM)\)|@.*|\d+-Core.*|Processor)", "", name).strip()


def three(value):
    """Three digits."""
    return f"{value:.3g}"


def block(bench, load):
    """The text between the marks."""
    machine, series = bench["machine"], bench["tables"]["series"]
    full = series["rows"]["full"]
    words = (
        f"Ours: {machine['threads']} cores of an {processor()}, {machine['simd'].upper()}, with a load of "
        f"{load:.0f} from other work. Medians of {series['runs']} runs of `ensonify bench --only series`; stages "
        "are milliseconds of one core, and pings/s include the files of the time series. "
        "[performance.md](performance.md) has times of a quieter machine."
    )
    lines = [
        textwrap.fill(words, 100, break_on_hyphens=False),
        "",
        "| `full`: 512 × 114 rays, 60 m, 29.9 kHz | the paper, RTX 2080 Ti | ensonify |",
        "|---|---|---|",
    ]
    core_ms = 0
    for words, paper, stages in STAGES:
        ours = sum(full["stages_ms"][stage] for stage in stages)
        core_ms += ours
        names = " + ".join(f"`{stage}`" for stage in stages)
        lines.append(f"| {words} | {paper} | {three(ours)} ms ({names}) |")
    lines.append(
        f"| pings/s | 0.5 | {three(full['pings_per_s'])}; {three(1000 / core_ms)} on one core without files |"
    )
    lines += [
        "",
        "| case | rays per beam | range bins | pings/s | error of the time series |",
        "|---|---|---|---|---|",
    ]
    for name in CASES:
        row = series["rows"][name]
        least, middle, most = (three(row[f"pings_per_s{end}"]) for end in ("_least", "", "_most"))
        lines.append(
            f"| `{name}` | {row['rays'] / row['beams']:.0f} | {row['samples']:.0f} | "
            f"{middle} ({least} to {most}) | {row['error']:.1e} |"
        )
    return "\n".join(lines)


def kept(page):
    """The block of a page that was written before."""
    text = pathlib.Path(page).read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        raise SystemExit(f"{page} has no times to keep: run without --keep-times once")
    return text.split(BEGIN)[1].split(END)[0].strip()

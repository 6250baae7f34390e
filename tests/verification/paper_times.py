"""Table 2: run times of `ensonify bench` beside those of the paper."""
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import textwrap

CASES = ("full", "table1", "reduced")
BEGIN, END = "<!-- times -->", "<!-- end of times -->"
# Stage of the paper, its time on its device, and the stages of ours that do the same work.
STAGES = (
    ("rays", "0.3 s", ("trace", "scatterers")),
    ("summation over echoes", "1.26 s", ("speckle", "ray_sum_and_fft")),
    ("correction (Eq 16)", "0.05 s", ("mixing",)),
    ("transforms", "0.03 s", ()),
)
REPEATS = 3


def measured(program):
    """The JSON of every case of every repeat, and how busy the machine was before."""
    runs, load = {name: [] for name in CASES}, os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="ensonify-") as folder:
        place = pathlib.Path(folder) / "bench.json"
        for _ in range(REPEATS):
            for name in CASES:
                command = [program, "bench", "--only", "stages", "--case", name]
                subprocess.run(
                    [*command, "--json", str(place), "--disk", folder],
                    check=True,
                    capture_output=True,
                )
                runs[name].append(json.loads(place.read_text(encoding="utf-8")))
    return runs, load


def processor():
    """Name of the processor, without what marks and clocks add to it."""
    found = re.search(
        r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    )
    name = found.group(1) if found else "unknown"
    return re.sub(r"\s*(\((R|TM)\)|@.*|\d+-Core.*|Processor)", "", name).strip()


def median(runs, case, *path):
    """Median over repeats of one number of a case."""
    numbers = []
    for run in runs[case]:
        number = run["cases"][case]
        for key in path:
            number = number[key]
        numbers.append(number)
    return statistics.median(numbers)


def three(value):
    """Three digits."""
    return f"{value:.3g}"


def block(runs, load):
    """The text between the marks."""
    machine = runs[CASES[0]][0]["machine"]
    words = (
        f"Ours: {machine['threads']} cores of an {processor()}, {machine['simd'].upper()}, with a load of "
        f"{load:.0f} from other work. Medians of {REPEATS} runs of `ensonify bench`; stages are milliseconds "
        "of one core. [performance.md](performance.md) has times of a quieter machine."
    )
    lines = [
        textwrap.fill(words, 100, break_on_hyphens=False),
        "",
        "| `full`: 512 × 114 rays, 60 m, 29.9 kHz | the paper, RTX 2080 Ti | ensonify |",
        "|---|---|---|",
    ]
    for words, paper, stages in STAGES:
        ours = sum(median(runs, "full", "stages_ms", stage) for stage in stages)
        names = " + ".join(f"`{stage}`" for stage in stages)
        text = f"{three(ours)} ms ({names})" if stages else "in the sum"
        lines.append(f"| {words} | {paper} | {text} |")
    lines.append(
        f"| pings/s | 0.5 | {three(median(runs, 'full', 'pings_per_s'))}; "
        f"{three(median(runs, 'full', 'pings_per_s_1_thread'))} on one core |"
    )
    lines += [
        "",
        "| case | rays per beam | range bins | pings/s | error of the time series |",
        "|---|---|---|---|---|",
    ]
    for name in CASES:
        numbers = runs[name][0]["cases"][name]
        speeds = [run["cases"][name]["pings_per_s"] for run in runs[name]]
        lines.append(
            f"| `{name}` | {numbers['rays_per_beam']} | {numbers['samples']} | "
            f"{three(statistics.median(speeds))} ({three(min(speeds))} to {three(max(speeds))}) | "
            f"{median(runs, name, 'error'):.1e} |"
        )
    return "\n".join(lines)


def kept(page):
    """The block of a page that was written before."""
    text = pathlib.Path(page).read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        raise SystemExit(f"{page} has no times to keep: run without --keep-times once")
    return text.split(BEGIN)[1].split(END)[0].strip()

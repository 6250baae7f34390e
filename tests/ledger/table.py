"""The rows of the ledger: reading, writing, comparing, and the table of docs/performance.md.

A file has a row on each line, `name  value  # unit`. The name's first part is its kind.
"""
import re

ROW = re.compile(r"(?P<name>[\w.+-]+)\s+(?P<value>\d+)(?:\s+#\s*(?P<unit>.*))?")
# A row may grow by a share or by a number, whichever is more. A million instructions take a third of a millisecond.
ALLOWED = {"lines": (0, 200), "stage": (0.10, 1_000_000)}
ALLOWED_OTHERS = (0.05, 0)
UNITS = {"lines": "lines", "preprocessed": "lines that the compiler reads", "start": "",
         "instructions": "instructions", "stage": "instructions", "bytes": "bytes", "memory": "kB"}


def read(path):
    """{name: value}; ValueError with file and line where a line is neither a row nor a comment."""
    rows = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        found = ROW.fullmatch(line.strip())
        if not found or found["name"] in rows:
            raise ValueError(f"{path.name}:{number}: {line.strip()!r}; expected a new name, a whole number, # unit")
        rows[found["name"]] = int(found["value"])
    return rows


def kind(name):
    return name.split(".")[0]


def group(name):
    """The kind with which a row is measured: stages come with the instructions of the whole."""
    return "instructions" if kind(name) == "stage" else kind(name)


def write(path, rows):
    """Keeps the comment at the head of the file."""
    old = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    head = [line for line in old if line.startswith("#")]
    width = max(map(len, rows))
    body = [f"{name:{width}} {value:14}  # {UNITS[kind(name)]}".rstrip(" #") for name, value in rows.items()]
    path.write_text("\n".join([*head, *body]) + "\n", encoding="utf-8")


def allowed(name, committed):
    """The largest value that is no growth."""
    share, number = ALLOWED.get(kind(name), ALLOWED_OTHERS)
    return committed + max(committed * share, number)


def verdict(name, committed, measured):
    """'' where the row holds, 'lower' where it is worth renewing; all else fails."""
    if committed is None:
        return "NEW: no such row in the file"
    if measured is None:
        return "GONE: not measured any more"
    most = allowed(name, committed)
    if measured > most:
        return f"HIGHER than allowed ({most:,.0f})"
    return "lower: renew the file" if measured < 2 * committed - most else ""


def digits(value, unknown):
    return unknown if value is None else f"{value:,}"


def change(committed, measured):
    if committed is None or measured is None or committed == measured:
        return ""
    return f"{100 * (measured / committed - 1):+.1f} %" if committed else f"{measured - committed:+}"


def compare(committed, measured):
    """[(name, committed, measured, verdict)] of every row of either."""
    names = list(committed) + [name for name in measured if name not in committed]
    return [(name, committed.get(name), measured.get(name), verdict(name, committed.get(name), measured.get(name)))
            for name in names]


def failures(rows):
    return [row for row in rows if row[3] and not row[3].startswith("lower")]


def text(rows):
    width = max(len(row[0]) for row in rows)
    lines = [f"{'row':{width}} {'committed':>15} {'measured':>15} {'change':>9}"]
    for name, old, new, said in rows:
        values = f"{digits(old, '-'):>15} {digits(new, '-'):>15} {change(old, new):>9}"
        lines.append(f"{name:{width}} {values}  {said}".rstrip())
    return "\n".join(lines)


def markdown(columns):
    """A table with a column for each {heading: rows}, and the change from the first to the last. Without stages, which
    are too many to read."""
    first, last = next(iter(columns.values())), list(columns.values())[-1]
    lines = ["| row | " + " | ".join(columns) + " | change |", "|---|" + "---|" * (len(columns) + 1)]
    for name in dict.fromkeys(name for rows in columns.values() for name in rows if kind(name) != "stage"):
        cells = [digits(rows.get(name), "–") for rows in columns.values()]
        lines.append(f"| `{name}` | " + " | ".join(cells) + f" | {change(first.get(name), last.get(name)) or '–'} |")
    return "\n".join(lines)

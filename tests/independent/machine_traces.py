"""Nothing of the machine may stand in a compared file: host name, paths, times of day."""
import os
import re
import socket

import sonar_dataset

TIME_OF_DAY = re.compile(rb"(19|20)\d\d-\d\d-\d\d[T _]\d\d:\d\d|\b\d\d:\d\d:\d\d\b")
TEXT_ENDINGS = (".json", ".csv", ".txt", ".md", ".yaml", ".tum", ".sha256", ".html")
EXR_ATTRIBUTES_OF_THE_MACHINE = {
    "capDate",
    "utcOffset",
    "owner",
    "hostComputer",
    "host",
    "software",
}


def files_below(root):
    """Relative paths of all files, with folders that hold none given as themselves."""
    found = set()
    for folder, folders, files in os.walk(root):
        base = os.path.relpath(folder, root)
        found |= {os.path.normpath(os.path.join(base, name)) for name in files}
        if not folders and not files:
            found.add(os.path.normpath(base) + os.sep)
    return found


def check_machine(checklist, data_set):
    """No host name, path of the machine or time of day in any file but provenance.json.

    The names looked for are those of the machine that runs the check.
    """
    host = socket.gethostname()
    host_word = re.compile(rb"\b" + re.escape(host.encode()) + rb"\b")
    needles = [
        os.path.abspath(data_set.root),
        os.getcwd(),
        os.path.expanduser("~"),
        "/tmp/",
        "/home/",
    ]
    # Shorter ones turn up in packed pixels by chance.
    needles = [n.encode() for n in [host] + needles if len(n) > 4]
    faults = []
    for path in sorted(files_below(data_set.root) - {"provenance.json"}):
        full = data_set.path(path)
        if os.path.islink(full):
            faults.append(f"{path} is a link")
        if not os.path.isfile(full):
            continue
        with open(full, "rb") as stream:
            data = stream.read()
        faults += [f"{path} holds {needle.decode()!r}" for needle in needles if needle in data]
        if path.endswith(TEXT_ENDINGS):
            faults += [
                f"{path} holds {match.group(0).decode()!r}"
                for pattern in (TIME_OF_DAY, host_word)
                if (match := pattern.search(data))
            ]
        if path.endswith(".png"):
            faults += [
                f"{path} has the chunk {name}"
                for name in sonar_dataset.read_png_chunk_names(full)
                if name == "tIME"
            ]
        if path.endswith(".exr"):
            faults += [
                f"{path} has the attribute {name}"
                for part in sonar_dataset.read_exr(full)
                for name in part.attributes
                if name in EXR_ATTRIBUTES_OF_THE_MACHINE
            ]
    checklist.expect_none(faults, f"traces of the machine (host {host!r})")

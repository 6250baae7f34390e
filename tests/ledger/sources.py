"""Lines by folder, and the lines that the compiler reads for the program and for its tests."""
import concurrent.futures
import re
import shlex
import subprocess

FOLDERS = ("generator", "tests", "scripts", "output_schema")


def line_count(path):
    """Of text; 0 for what is not text, and for links."""
    if path.is_symlink() or not path.is_file():
        return 0
    content = path.read_bytes()
    return 0 if b"\0" in content else content.count(b"\n")


def lines_by_folder(root):
    """Every file that Git tracks or would add, by folder of generator/, and of each folder of FOLDERS."""
    listed = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files", "-z", "--cached", "--others", "--exclude-standard", *FOLDERS],
        cwd=root, capture_output=True, text=True)
    if listed.returncode != 0:
        raise RuntimeError(f"{root}: lines are those of files of a Git repository; git says: {listed.stderr.strip()}")
    rows = {}
    for name in sorted(set(listed.stdout.split("\0")) - {""}):
        parts = name.split("/")
        groups = {parts[0]}
        if parts[0] == "generator" and len(parts) > 2:
            groups.add("generator." + parts[1])
        for group in groups:
            rows[f"lines.{group}"] = rows.get(f"lines.{group}", 0) + line_count(root / name)
    return dict(sorted(rows.items()))


def compile_commands(build, target):
    """{object: the command as words} of the C++ that Ninja would compile for the target, without a compiler cache."""
    printed = subprocess.run(["ninja", "-t", "commands", target], cwd=build, capture_output=True, text=True)
    if printed.returncode != 0:
        raise RuntimeError(f"{build}: {printed.stderr.strip()}; expected a build of the preset release by Ninja")
    commands = {}
    for line in printed.stdout.splitlines():
        words = shlex.split(line)
        compiler = next((i for i, word in enumerate(words) if word.endswith("++")), None)
        if compiler is not None and "-c" in words and not words[words.index("-c") + 1].endswith(".cu"):
            commands[words[words.index("-o") + 1]] = words[compiler:]
    return commands


def lines_read(build, output, words):
    """Lines of code after preprocessing. What a precompiled header brings is left out of its users, where the compiler
    reads it as one block; the preprocessor pastes its text there, before the unit's own."""
    words = [word for word in words if word not in ("-fpch-preprocess", "-MD")]
    for option in ("-MT", "-MF", "-o"):
        at = words.index(option)
        del words[at:at + 2]
    words[words.index("-c")] = "-E"
    done = subprocess.run(words, cwd=build, capture_output=True)
    if done.returncode != 0:
        raise RuntimeError(f"{output}: cannot be preprocessed: {done.stderr.decode()[:400]}")
    own = done.stdout
    if not output.endswith(".gch"):
        own = own[own.rfind(b'\n# 0 "<command-line>" 2'):]
    return len(re.findall(rb"^[^#\n]", own, re.MULTILINE))


def preprocessed(build):
    program = compile_commands(build, "ensonify")
    tests = compile_commands(build, "test_programs")
    tests = {output: tests[output] for output in tests.keys() - program.keys()}
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return {f"preprocessed.{name}": sum(pool.map(lines_read, [build] * len(units), units.keys(), units.values()))
                for name, units in (("program", program), ("tests", tests))}


def job_seconds(build):
    """The sum of Ninja's log, or None. It holds the last build of every object, whatever else the machine did."""
    log = build / ".ninja_log"
    if not log.exists():
        return None
    last = {}
    for fields in (line.split("\t") for line in log.read_text(encoding="utf-8").splitlines()):
        if len(fields) == 5 and fields[3].endswith((".o", ".gch")):
            last[fields[3]] = (int(fields[1]) - int(fields[0])) / 1000
    return sum(last.values())

"""The Python of a page: one process, blocks in order, statement by statement.

Reads one JSON object a line, {"text", "name", "cwd"}, and answers with one, {"error", "printed",
"skipped"}. A statement that needs a module of OPTIONAL that is not installed is left out, and so is
every later one that uses a name which such a statement would have set."""

import ast
import json
import os
import sys
import tempfile
import traceback

OPTIONAL = {"cv2", "evo", "h5py", "matplotlib", "mcap_ros2", "open3d", "pyopenvdb", "torch", "torchvision",
            "ultralytics", "webdataset"}


def left_out():
    """The modules and programs of ENSONIFY_DOCS_WITHOUT."""
    return {name for name in os.environ.get("ENSONIFY_DOCS_WITHOUT", "").split(",") if name}


def names(node, context):
    found = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, context)}
    if context is ast.Store:
        for n in ast.walk(node):
            if isinstance(n, (ast.FunctionDef, ast.ClassDef)):
                found.add(n.name)
            if isinstance(n, ast.alias):
                found.add((n.asname or n.name).split(".")[0])
    return found


def one_import_each(statement):
    """`import csv, cv2` as two, so that the one that is missing takes no other with it."""
    if not isinstance(statement, ast.Import):
        return [statement]
    return [ast.copy_location(ast.Import([alias]), statement) for alias in statement.names]


def run(text, name, space, missing):
    """Executes a block; the reasons of what was left out. missing: name -> module."""
    skipped = []
    tree = ast.parse(text, name)
    for statement in (part for whole in tree.body for part in one_import_each(whole)):
        module = next((missing[n] for n in sorted(names(statement, ast.Load)) if n in missing), None)
        if module is None:
            try:
                exec(compile(ast.Module([statement], []), name, "exec"), space)
                for done in names(statement, ast.Store):
                    missing.pop(done, None)
                continue
            except ModuleNotFoundError as error:
                module = (error.name or "").split(".")[0]
                if module not in OPTIONAL:
                    raise
        missing.update({n: module for n in names(statement, ast.Store)})
        skipped.append(f"no Python module {module}")
    return skipped


def main():
    requests = os.fdopen(os.dup(0), "r", encoding="utf-8")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    space, missing = {"__name__": "__main__"}, {}
    sys.modules.update(dict.fromkeys(left_out()))  # None: its import fails as that of a missing one
    for line in requests:
        request = json.loads(line)
        os.chdir(request["cwd"])
        # Files, not sys.stdout: libraries write past it.
        with tempfile.TemporaryFile("w+", encoding="utf-8") as printed:
            os.dup2(printed.fileno(), 1)
            os.dup2(printed.fileno(), 2)
            error, skipped = "", []
            try:
                skipped = run(request["text"], request["name"], space, missing)
            except BaseException:
                error = traceback.format_exc()
            sys.stdout.flush()
            sys.stderr.flush()
            printed.seek(0)
            answer = {"error": error, "printed": printed.read(), "skipped": skipped}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()

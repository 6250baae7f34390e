"""Bookkeeping shared by the check scripts: obtained beside expected, exit status."""
import contextlib
import importlib
import io
import sys
import traceback

# CTest and automake read 77 as "skipped"; a check that cannot be worked out must not look passed.
SKIPPED = 77


class Checklist:
    """Collects single comparisons, prints each, and turns them into an exit status."""

    def __init__(self, title):
        self.title = title
        self.failures = []
        self.count = 0

    def expect(self, ok, what, obtained, expected):
        """Record one comparison; `obtained` and `expected` are printed as they are."""
        self.count += 1
        mark = "ok  " if ok else "FAIL"
        print(f"{mark} {what}: obtained {obtained}, expected {expected}")
        if not ok:
            self.failures.append(what)
        return bool(ok)

    def equal(self, what, obtained, expected):
        """Record that both are the same."""
        return self.expect(obtained == expected, what, obtained, expected)

    def expect_none(self, offenders, what, limit=5):
        """Record that a list of offenders is empty, naming the first few of them."""
        shown = "; ".join(str(item) for item in offenders[:limit])
        if len(offenders) > limit:
            shown += f"; and {len(offenders) - limit} more"
        return self.expect(not offenders, what, shown or "none", "none")

    def near(self, what, obtained, expected, tolerance, unit=""):
        """Record |obtained - expected| <= tolerance; NaN fails."""
        ok = abs(obtained - expected) <= tolerance
        return self.expect(
            ok, what, f"{obtained:.6g}{unit}", f"{expected:.6g}{unit} +- {tolerance:g}"
        )

    def at_most(self, what, obtained, limit, unit="", note=""):
        """Record obtained <= limit; NaN fails."""
        wanted = f"<= {limit:g}{unit} {note}".rstrip()
        return self.expect(obtained <= limit, what, f"{obtained:.6g}{unit}", wanted)

    def none_of(self, what, wrong, count):
        """Record that none of so many is wrong."""
        return self.expect(wrong == 0, what, wrong, f"0 of {count}")

    def note(self, text):
        """Print something that is measured but not judged."""
        print(f"     {text}")

    def finish(self):
        """Print the verdict and return the exit status."""
        if self.failures:
            print(
                f"{self.title}: {len(self.failures)} of {self.count} checks FAILED, "
                f"first: {self.failures[0]}"
            )
            return 1
        print(f"{self.title}: {self.count} checks passed")
        return 0 if self.count else 1


def run_main(title, check, argument_count=1):
    """Run `check(checklist, *arguments)` as a script; ValueError and missing files are failures."""
    if len(sys.argv) != argument_count + 1:
        print(
            f"usage: {sys.argv[0]} " + " ".join(["DATASET_DIR"] * argument_count), file=sys.stderr
        )
        return 2
    checklist = Checklist(title)
    try:
        status = check(checklist, *sys.argv[1:])
    except (ValueError, KeyError, OSError) as error:
        checklist.expect(False, "data can be read", f"{type(error).__name__}: {error}", "no error")
        status = None
    return status if status is not None else checklist.finish()


def run_check(name, *arguments):
    """Exit status and output of a check script, run in this process."""
    printed, own = io.StringIO(), sys.argv
    sys.argv = [name, *map(str, arguments)]
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            status = run_main(name, importlib.import_module(name).check, len(arguments))
    except Exception:
        status = 1
        printed.write(traceback.format_exc())
    finally:
        sys.argv = own
    return status, printed.getvalue()

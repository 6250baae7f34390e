"""The comparison of the ledger: growth fails, noise does not, and the committed files and the page agree."""
import contextlib
import io
import pathlib
import re
import tempfile
import unittest

import counted
import jobs
import ledger
import sources
import table

COMMITTED = {"lines.generator.app": 12000, "instructions.version": 221_000_000, "stage.tank.hash": 160_000_000,
             "bytes.hashed": 227_123}
PROFILE = """version: 1
fn=(1) main
0 10
cfn=(2) ensonify::sha256_hex(std::string_view)
calls=2 0
0 500
fn=(2)
0 300
cfn=(3) ensonify::Sha256::update(std::string_view)
calls=2 0
0 200
fn=(3)
+1 200
fn=(4) ensonify::Sha256::update(std::string_view)::{lambda()#1}::operator()() const
* 40
"""


def failed(**moved):
    """The names of the rows that fail when these, with `_` for `.`, have other values."""
    measured = dict(COMMITTED)
    for name, value in moved.items():
        measured[next(row for row in COMMITTED if row.replace(".", "_") == name)] = value
    return [row[0] for row in table.failures(table.compare(COMMITTED, measured))]


class Comparison(unittest.TestCase):
    def test_the_same_values_pass(self):
        self.assertEqual(failed(), [])

    def test_noise_passes(self):
        self.assertEqual(failed(lines_generator_app=12200, instructions_version=232_000_000,
                                stage_tank_hash=175_900_000, bytes_hashed=238_000), [])

    def test_each_kind_fails_beyond_its_limit(self):
        self.assertEqual(failed(lines_generator_app=12201), ["lines.generator.app"])
        self.assertEqual(failed(instructions_version=232_100_000), ["instructions.version"])
        self.assertEqual(failed(stage_tank_hash=176_100_000), ["stage.tank.hash"])
        self.assertEqual(failed(bytes_hashed=2 * 227_123), ["bytes.hashed"])

    def test_a_fall_passes_and_asks_for_a_new_file(self):
        rows = table.compare(COMMITTED, {**COMMITTED, "instructions.version": 100_000_000})
        self.assertEqual(table.failures(rows), [])
        self.assertIn("lower", table.text(rows))

    def test_a_row_that_comes_or_goes_fails(self):
        self.assertEqual(table.failures(table.compare(COMMITTED, {**COMMITTED, "lines.generator.new": 5}))[0][0],
                         "lines.generator.new")
        rest = {name: value for name, value in COMMITTED.items() if name != "bytes.hashed"}
        self.assertEqual(table.failures(table.compare(COMMITTED, rest))[0][0], "bytes.hashed")

    def test_elsewhere_only_lines_are_compared(self):
        for name, status in (("bytes.hashed", 0), ("lines.generator.app", 1)):
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                self.assertEqual(ledger.check(COMMITTED, {**COMMITTED, name: 10 ** 6}, False), status)
            self.assertIn("1,000,000", printed.getvalue())

    def test_a_failure_names_the_row_and_the_remedy(self):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(ledger.check(COMMITTED, {**COMMITTED, "bytes.hashed": 454_246}, True), 1)
        for part in ("bytes.hashed", "+100.0 %", "--write"):
            self.assertIn(part, printed.getvalue().split("1 failed")[1])


class Files(unittest.TestCase):
    def test_a_file_is_read_as_it_was_written(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "rows.txt"
            file.write_text("# why\n")
            table.write(file, COMMITTED)
            self.assertEqual(table.read(file), COMMITTED)
            self.assertTrue(file.read_text().startswith("# why\n"))
            file.write_text("bytes.hashed 1e3\n")
            with self.assertRaisesRegex(ValueError, "rows.txt:1"):
                table.read(file)

    def test_the_page_has_the_table_of_the_files(self):
        page = ledger.PAGE.read_text(encoding="utf-8")
        self.assertEqual(ledger.filled(page), page, "run tests/ledger/ledger.py --page")
        self.assertIn("| `bytes.hashed` |", page)

    def test_a_profile_gives_what_functions_and_their_calls_cost(self):
        with tempfile.TemporaryDirectory() as folder:
            profile = pathlib.Path(folder) / "profile"
            profile.write_text(PROFILE)
            counts = counted.inclusive(profile)
        self.assertEqual(counts["main"], 510)
        self.assertEqual(counted.of_functions(counts, ["sha256_hex(", "Sha256::update(", "no_such("]),
                         {"sha256_hex(": 500, "Sha256::update(": 200})

    def test_lines_are_those_of_text(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "file"
            file.write_bytes(b"one\ntwo\n")
            self.assertEqual(sources.line_count(file), 2)
            file.write_bytes(b"\0\n\n")
            self.assertEqual(sources.line_count(file), 0)


class Stages(unittest.TestCase):
    def test_every_function_that_a_ping_calls_is_counted_or_left_out_on_purpose(self):
        """Protects the rows of stages: the time of a new one would be in none of them."""
        generator = pathlib.Path(__file__).resolve().parents[2] / "generator"
        declared, called = set(), set()
        for folder in ("trace", "labels", "synthesis", "instrument"):
            for header in (generator / folder).glob("*.h"):
                declared.update(re.findall(r"^(?!inline|constexpr)\w[\w:<>,&* ]*? [*&]?([a-z_]\w*)\(",
                                           header.read_text(), re.M))
        for name in ("pipeline", "ping_echoes", "ping_series", "pictures"):
            called.update(re.findall(r"(?<![.>:\w])([a-z_]\w*)\(", (generator / f"ping/{name}.cpp").read_text()))
        staged = {re.match(r"[\w:]+", name)[0] for names in jobs.STAGES.values() for name in names}
        self.assertGreater(len(called & declared & staged), 15)
        self.assertEqual(sorted((called & declared) - staged), jobs.UNCOUNTED, "see STAGES and UNCOUNTED of jobs.py")


if __name__ == "__main__":
    unittest.main()

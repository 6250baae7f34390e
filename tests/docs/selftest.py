"""That a page which shows what is not so fails, and a page that is right does not."""

import contextlib
import io
import os
import tempfile
import unittest
from pathlib import Path

import commands_test
from compare import difference, split_console
from pages import BadPage

PROGRAM = os.environ["ENSONIFY"]


def fenced(language, text, directive=""):
    head = f"<!-- docs-test: {directive} -->\n" if directive else ""
    return f"{head}```{language}\n{text}\n```\n\n"


class PageTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        for name in ("generator", "tests", "scenes"):
            (self.root / name).mkdir()

    def tearDown(self):
        self.folder.cleanup()

    def run_text(self, *blocks):
        (self.root / "page.md").write_text("# Page\n\n" + "".join(blocks), encoding="utf-8")
        return commands_test.run_page("page.md", PROGRAM, self.root)

    def good(self, *blocks):
        outcome = self.run_text(*blocks)[1]
        self.assertEqual(outcome.failures, [])
        return outcome

    def bad(self, *blocks):
        """The first failure's line and text."""
        outcome = self.run_text(*blocks)[1]
        self.assertEqual(len(outcome.failures), 1, outcome.failures)
        return outcome.failures[0]


class Commands(PageTest):
    def test_a_command_that_fails(self):
        line, text = self.bad(fenced("sh", "true\nfalse\ntrue"))
        self.assertEqual(line, 3)
        self.assertIn("exit status 1, not 0", text)
        self.bad(fenced("console", "$ ensonify chek"))
        self.bad(fenced("sh", "false | true"))

    def test_an_expected_failure(self):
        self.good(fenced("sh", "exit 3", "fails=3"), fenced("console", "$ ensonify chek\n…", "fails=2"))
        self.bad(fenced("sh", "true", "fails=3"))

    def test_an_output_that_differs(self):
        self.good(fenced("console", "$ echo a; echo b\na\nb\n$ echo c\nc"))
        line, text = self.bad(fenced("console", "$ echo a\na\n$ echo b\nc"))
        self.assertEqual(line, 6)
        self.assertIn("-c\n+b", text)
        self.bad(fenced("console", "$ echo a >&2\nb"))
        self.bad(fenced("console", "echo a\na"))

    def test_an_output_in_a_block_of_its_own(self):
        self.good(fenced("sh", "echo 1"), fenced("text", "1", "output"))
        self.good(fenced("python", "print(1)"), fenced("text", "1", "output"))
        self.bad(fenced("sh", "echo 1"), fenced("text", "2", "output"))
        self.bad(fenced("text", "2", "output"))

    def test_variables_and_folder_last(self):
        self.good(fenced("sh", "export A=5; mkdir sub; cd sub"),
                  fenced("console", "$ echo $A; pwd\n5\n/home/me/ensonify/sub"),
                  fenced("python", "import os\nassert os.environ['A'] == '5' and os.getcwd().endswith('sub')"))

    def test_the_program_is_the_one_under_test(self):
        self.good(fenced("sh", f'test "$(realpath build/release/ensonify)" = "{os.path.realpath(PROGRAM)}"\n'
                               'test build/release/ensonify -ef "$(command -v ensonify)"'))

    def test_nothing_is_built_or_installed(self):
        self.bad(fenced("sh", "sudo apt-get install x"))
        self.bad(fenced("sh", "cmake --preset release"))


class Languages(PageTest):
    def test_no_language(self):
        self.assertIn("unknown language ''", self.bad(fenced("", "DIR/"))[1])

    def test_scenarios(self):
        whole = "ensonify: 1\nname: a\nsonar: {preset: blueview_p900_90}"
        self.good(fenced("yaml", whole), fenced("yaml", "water: {sound_speed_m_s: 1490}"))
        self.assertIn("sonr", self.bad(fenced("yaml", whole.replace("sonar", "sonr")))[1])
        self.bad(fenced("yaml", "water: {sound_sped_m_s: 1490}"))

    def test_parts_beside_a_file(self):
        base = fenced("yaml", "ensonify: 1\nname: a\nsonar: {preset: blueview_p900_90}\n"
                              "materials:\n  mud: {reflectivity: 1e-3}", "file=base.yaml")
        ball = fenced("yaml", "objects:\n  - {name: b, material: mud, shape: {sphere: {radius_m: 1}}}",
                      "base=base.yaml")
        self.good(base, ball)
        self.bad(base, ball.replace("mud", "mad"))

    def test_sweeps(self):
        files = fenced("yaml", "ensonify: 1\nname: a\nsonar: {preset: blueview_p900_90}", "file=a.yaml")
        sweep = "ensonify_sweep: 1\nname: s\nbase: a.yaml\naxes: [{key: seed, values: [1, 2]}]"
        self.good(files, fenced("yaml", sweep))
        self.bad(files, fenced("yaml", sweep.replace("values", "valus")))

    def test_python_goes_on_and_fails(self):
        self.good(fenced("python", "a = 1"), fenced("python", "assert a == 1"))
        self.assertIn("AssertionError", self.bad(fenced("python", "a = 1"), fenced("python", "assert a == 2"))[1])
        self.bad(fenced("python", "import no_such_module_at_all"))

    def test_statements_without_their_module(self):
        outcome = self.good(fenced("python", "import sys, ultralytics\nx = ultralytics.YOLO()\ny = sys.path"),
                            fenced("python", "print(x)\nassert y"))
        self.assertEqual([reason for _, reason in outcome.skips],
                         ["2 statements: no Python module ultralytics",
                          "1 statement: no Python module ultralytics"])

    def test_json_and_csv(self):
        self.good(fenced("json", '{"a": 1}'), fenced("json", '"a": 1'), fenced("csv", "a,b\n1,2"))
        self.bad(fenced("json", "{a: 1}"))
        self.bad(fenced("csv", "a,b\n1"))


class Directives(PageTest):
    def test_skip_has_a_reason_that_is_told(self):
        self.assertEqual(self.good(fenced("sh", "false", "skip=a cluster")).skips, [(4, "a cluster")])
        for directive in ("skip", "skip=", "skpi=x"):
            with self.assertRaises(BadPage):
                self.run_text(fenced("sh", "false", directive))

    def test_needs(self):
        self.assertEqual(len(self.good(fenced("sh", "false", "needs=no_such_program")).skips), 1)
        self.bad(fenced("sh", "false", "needs=bash"))

    def test_files_stay_in_the_folder(self):
        self.good(fenced("csv", "a,b", "file=t/a.csv"), fenced("console", "$ cat t/a.csv\na,b"))
        with self.assertRaises(ValueError):
            self.run_text(fenced("csv", "a,b", "file=tests/a.csv"))

    def test_a_directive_belongs_to_a_block(self):
        with self.assertRaises(BadPage):
            self.run_text("<!-- docs-test: varies -->\n\ntext\n")
        with self.assertRaises(BadPage):
            self.run_text("```sh\ntrue\n")

    def test_write(self):
        page, outcome = self.run_text(fenced("console", "$ echo 1; echo 2\nx\n$ echo 3\n3"))
        with contextlib.redirect_stdout(io.StringIO()):
            commands_test.write(page, outcome)
        self.assertIn("$ echo 1; echo 2\n1\n2\n$ echo 3\n3\n", page.path.read_text(encoding="utf-8"))
        self.assertTrue(commands_test.has_failed(outcome, written=False))
        self.assertFalse(commands_test.has_failed(outcome, written=True))
        again = commands_test.run_page("page.md", PROGRAM, self.root)[1]
        self.assertEqual(again.failures, [])
        broken = self.run_text(fenced("console", "$ echo 1\nx\n$ false"))[1]
        self.assertTrue(commands_test.has_failed(broken, written=True))


class Comparison(unittest.TestCase):
    def test_ellipsis(self):
        for shown in ("a … c", "…", "a b c\n…", "…\n…c"):
            self.assertIsNone(difference(shown, "a b c\n"), shown)
        self.assertIsNone(difference("a\n…\nd", "a\nb\nc\nd"))
        for shown in ("a … d", "…\nb", "a", "a…\nb c"):
            self.assertIsNotNone(difference(shown, "a b c"), shown)

    def test_numbers(self):
        self.assertIsNone(difference("3.2 s, 10 MB/s, 5 pings", "11 s,   9 MB/s, 5 pings", ""))
        self.assertIsNotNone(difference("3.2 s, 5 pings", "3.2 s, 6 pings", ""))
        self.assertIsNotNone(difference("3.2 s", "2.9 s"))
        self.assertIsNone(difference("5 pings", "6 pings", "numbers"))
        self.assertIsNotNone(difference("5 pings", "6 rings", "numbers"))

    def test_numbers_of_another_processor(self):
        for printed in ("contrast 1.014", "contrast 1.012", "contrast 1.005"):
            self.assertIsNone(difference("contrast 1.013", printed), printed)
        for printed in ("contrast 1.03", "contrast -1.013", "contrast x", "contrast 1.013 1"):
            self.assertIsNotNone(difference("contrast 1.013", printed), printed)
        self.assertIsNone(difference("27660 pixels, -0.002", "27658  pixels, 0.000"))
        self.assertIsNotNone(difference("27660 pixels", "28000 pixels"))
        self.assertIsNotNone(difference("12 beams", "13 beams"))
        self.assertIsNotNone(difference("id 000003", "id 000004"))

    def test_commands_over_several_lines(self):
        text = "$ a \\\n    b\nout\n$ cat <<E\n> x\n> E\nx\n"
        self.assertEqual([(c, o) for c, o, _, _ in split_console(text)],
                         [("a \\\n    b", "out"), ("cat <<E\nx\nE", "x")])


if __name__ == "__main__":
    unittest.main()

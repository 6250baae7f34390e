"""`ensonify figure` from outside: SVG read by an XML parser, MP4 by a stand-in for ffmpeg."""
import os
import pathlib
import sys
import unittest
import xml.etree.ElementTree as ElementTree

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import program  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"

SCENARIO = """ensonify: 1
name: drawn
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 60}
  rays: {elevation: 8}
materials: {m: {reflectivity: 1e-3}, s: {reflectivity: 1e-1}}
objects:
  - {name: room, class: "room <1>", material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
  - {name: "ball & <net>", class: ball, material: s, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0.3, 0]}}
trajectory: {ping_rate_hz: 5, pings: 4}
"""

# Writes what it is given behind its arguments; its output is the last of them.
STAND_IN = """#!/bin/sh
printf '%s\\n' "$@" > "$FIGURE_TEST/arguments"
cut -d ' ' -f 1,5 /proc/$$/stat > "$FIGURE_TEST/groups"
for last; do :; done
cat > "${last#file:}"
"""
FAILING = """#!/bin/sh
echo "no encoder is
here" >&2
exit 3
"""


def run(*arguments, **environment):
    return program.run(*arguments, env={**os.environ, **environment})


def dataset():
    return program.made(SCENARIO)


class Figures(program.Case):
    def draw(self, name, *options, **environment):
        done = run("figure", dataset(), "-o", self.folder / name, *options, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / name

    def refuse(self, status, name, *options, expected, **environment):
        done = run("figure", dataset(), "-o", self.folder / name, *options, **environment)
        self.assertEqual(done.returncode, status, done.stderr)
        for part in expected:
            self.assertIn(part, done.stderr)
        self.assertFalse((self.folder / name).exists())
        self.assertEqual([p for p in self.folder.iterdir() if ".part-" in p.name], [])
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_svg_is_xml_with_the_names_in_it(self):
        root = ElementTree.parse(self.draw("f.svg", "--outlines")).getroot()
        self.assertEqual(root.tag, SVG + "svg")
        texts = [t.text for t in root.iter(SVG + "text")]
        self.assertIn("ball & <net>", texts)
        self.assertIn("drawn, ping 0, 0.00 s", texts)
        self.assertIn("ahead (m)", texts)
        self.assertEqual(len(list(root.iter(SVG + "image"))), 2)
        before = run("figure", "--outlines", "--instances", "room,ball & <net>", dataset(), "-o",
                     self.folder / "b.svg")
        self.assertEqual(before.returncode, 0, before.stderr)
        self.assertIn(">room</text>", (self.folder / "b.svg").read_text())
        mask = ElementTree.parse(self.draw("m.svg", "--quantity", "semantic")).getroot()
        self.assertIn("room <1>", [t.text for t in mask.iter(SVG + "text")])
        titled = ElementTree.parse(self.draw("t.svg", "--title", "a < b & c", "--view", "polar"))
        self.assertIn("a < b & c", [t.text for t in titled.getroot().iter(SVG + "text")])

    def test_every_quantity_and_the_message(self):
        for quantity in ["level", "clean", "elevation", "instance", "semantic", "shadow"]:
            for view in ["cartesian", "polar"]:
                png = self.draw(f"{quantity}_{view}.png", "--quantity", quantity, "--view", view,
                                "--width-px", 400)
                self.assertEqual(png.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        done = run("figure", dataset(), "-o", self.folder / "l.png", "--db", "50:110", "--ping", 2)
        self.assertIn("1 ping, 50 to 110 dB", done.stderr)
        self.assertEqual(run("figure", dataset(), "-o", self.folder / "q.png", "--quiet").stderr, "")

    def test_wrong_options(self):
        self.refuse(2, "f.png", "--db", "1-2", expected=["--db 1-2", "MIN:MAX"])
        self.refuse(2, "f.webp", "--pings", "1", expected=["--pings 1", "A:B"])
        self.refuse(2, "f.gif", expected=["f.gif", ".webp"])
        self.refuse(2, "f.png", "--title", "two\nlines", expected=["--title"])
        self.refuse(2, "f.png", "--color-map", "jet", expected=["jet", "cividis"])

    def test_mp4_goes_through_ffmpeg(self):
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "ffmpeg").write_text(STAND_IN)
        (tools / "ffmpeg").chmod(0o755)
        path = f"{tools}:{os.environ['PATH']}"
        film = self.draw("-a $(b);:c.mp4", "--pings", "1:4", "--width-px", 301, "--fps", 7.5,
                         PATH=path, FIGURE_TEST=str(self.folder))
        words = (self.folder / "arguments").read_text().split("\n")
        width, height = map(int, words[words.index("-s") + 1].split("x"))
        self.assertEqual((width % 2, height % 2), (0, 0))
        self.assertIn(width, [300, 302])
        self.assertEqual(film.stat().st_size, 3 * 3 * width * height)
        self.assertEqual(words[words.index("-r") + 1], "7.5")
        self.assertTrue(words[-2].startswith("file:/"))
        # Ctrl-C of a terminal goes to a whole process group, and the program ends the encoder itself.
        process, group = (self.folder / "groups").read_text().split()
        self.assertEqual(process, group)

    def test_mp4_without_ffmpeg_or_with_one_that_fails(self):
        empty = self.folder / "empty"
        empty.mkdir()
        self.refuse(2, "f.mp4", PATH=str(empty), expected=["ffmpeg", "apt install ffmpeg", ".webp"])
        (empty / "ffmpeg").write_text(FAILING)
        (empty / "ffmpeg").chmod(0o755)
        self.refuse(4, "f.mp4", PATH=str(empty), expected=["status 3", "no encoder is here"])
        (empty / "ffmpeg").write_text("not a program")
        self.refuse(4, "f.mp4", PATH=str(empty), expected=["ffmpeg"])


if __name__ == "__main__":
    unittest.main()

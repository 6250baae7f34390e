"""`cmake --install` and the Debian package: the installed program finds what it needs, and nothing of the build.

BUILD is the build's folder, CMAKE and CPACK are the programs. Run by ctest; by hand:
    python3 -m unittest install_test    (build/release)
"""
import importlib.util
import os
import pathlib
import shutil
import tempfile
import unittest

from installed import BUILD, Installed, run

CPACK = os.environ.get("CPACK", "cpack")
REDUCED = ("--set", "sonar.beams={count: 16, fov_deg: 40}", "--set", "sonar.rays={elevation: 8, min_per_cell: 8}",
           "--pings", "0:1")
MISSING = [name for name in ("dpkg-shlibdeps", "dpkg-deb", "file") if not shutil.which(name)]


class Program(Installed):
    def generate(self, scene, *more):
        out = self.folder / f"out-{scene}{len(more)}"
        done = run(self.program, "generate", self.data / f"scenes/{scene}.yaml", "-o", out, *REDUCED, *more,
                   cwd=self.folder, env=self.environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out

    def test_a_scene_with_a_mesh(self):
        out = self.generate("seabed_and_target")
        self.assertTrue(list(out.rglob("*.png")))
        verified = run(self.program, "verify", out, env=self.environment)
        self.assertEqual(verified.returncode, 0, verified.stderr)

    def test_the_importer_is_the_installed_one(self):
        importer = self.prefix / "lib/ensonify/ensonify_import"
        aside = importer.with_name("aside")
        importer.rename(aside)
        self.addCleanup(aside.rename, importer)
        done = run(self.program, "generate", self.data / "scenes/seabed_and_target.yaml", "-o", self.folder / "none",
                   *REDUCED, env=self.environment)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("ensonify_import", done.stderr)

    def test_the_modules_are_the_installed_ones(self):
        out = self.generate("sonar_tank", "--set", "output.sdf={voxel_m: 0.1}")
        self.assertTrue(list(out.rglob("*.vdb")))
        commands = {"containers": ("export", out, "--format", "hdf5", "-o", self.folder / "set.h5"),
                    "raster": ("figure", out, "-o", self.folder / "ping.png")}
        for module, command in commands.items():
            done = run(self.program, *command, env=self.environment)
            self.assertEqual(done.returncode, 0, done.stderr)
            command[-1].unlink()
            file = self.prefix / f"lib/ensonify/libensonify_{module}.so"
            aside = file.with_suffix(".aside")
            file.rename(aside)
            self.addCleanup(aside.rename, file)
            done = run(self.program, *command, env=self.environment)
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertIn(f"{file.name}, a part of ensonify; build or install ensonify again", done.stderr)
            file.write_bytes(b"not a library")
            done = run(self.program, *command, env=self.environment)
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertIn("(Debian: apt-get install lib", done.stderr)

    def test_every_scene_and_sweep_is_read(self):
        scenes = sorted((self.data / "scenes").glob("*.yaml"))
        sweeps = sorted((self.data / "configs/sweeps").glob("*.yaml"))
        self.assertGreater(len(scenes), 10)
        self.assertGreater(len(sweeps), 2)
        for sweep in sweeps:
            done = run(self.program, "sweep", sweep, "--list", env=self.environment)
            self.assertEqual(done.returncode, 0, f"{sweep}: {done.stderr}")
        for scene in scenes:
            for mesh in scene.read_text(encoding="utf-8").split("file: meshes/")[1:]:
                name = mesh.split(",")[0].split("}")[0]
                self.assertTrue((scene.parent / "meshes" / name).is_file(), f"{scene}: {name}")

    def test_pages_are_where_documentation_is(self):
        self.assertTrue((self.prefix / "share/doc/ensonify/docs/scenario.md").is_file())
        self.assertTrue((self.data / "output_schema/scenario.schema.json").is_file())
        self.assertTrue((self.data / "configs/sonars/blueview_p900_90.yaml").is_file())

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "needs numpy")
    def test_the_reader(self):
        out = self.generate("sonar_tank")
        packages = self.prefix / "lib/python3/dist-packages"
        script = ("import ensonify_dataset, sys; print(ensonify_dataset.__file__);"
                  "print(ensonify_dataset.SonarDataset(sys.argv[1])[0].series.shape)")
        done = run("/usr/bin/python3", "-c", script, out, cwd=self.folder,
                   env={**self.environment, "PYTHONPATH": str(packages), "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(str(packages), done.stdout)
        self.assertIn("(16, ", done.stdout)

    def test_nothing_names_the_build(self):
        # Python's files and pages are texts; a path of the build in a program leads a user nowhere.
        for file in (self.prefix / "share").rglob("*"):
            if file.is_file() and file.suffix in ("", ".yaml", ".bash", ".fish", ".gz"):
                self.assertNotIn(str(BUILD).encode(), file.read_bytes(), file)


@unittest.skipIf(MISSING, f"not installed: {', '.join(MISSING)}")
class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-deb-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        done = run(CPACK, "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder)
        if done.returncode != 0:
            raise RuntimeError(done.stdout + done.stderr)
        (cls.deb,) = cls.folder.glob("ensonify_*.deb")

    def field(self, name):
        return run("dpkg-deb", "-f", self.deb, name).stdout.strip()

    def test_its_name(self):
        name = f"ensonify_{self.field('Version')}_{self.field('Architecture')}.deb"
        self.assertEqual(self.deb.name, name)

    def test_it_depends_on_the_libraries_of_its_programs(self):
        depends = self.field("Depends")
        # assimp is needed by the importer alone, and the last three by modules.
        for library in ("libc6", "libembree", "libopenvdb", "libassimp", "libfftw3-double3", "libhdf5", "libarchive",
                        "libcairo2"):
            self.assertIn(library, depends)
        self.assertNotIn("-dev", depends)

    def test_its_programs_are_stripped_and_its_own(self):
        unpacked = self.folder / "unpacked"
        self.assertEqual(run("dpkg-deb", "-x", self.deb, unpacked).returncode, 0)
        for name in ("bin/ensonify", "lib/ensonify/ensonify_import", "lib/ensonify/libensonify_sdf.so"):
            self.assertIn(", stripped", run("file", unpacked / "usr" / name).stdout)
        owners = {line.split()[1] for line in run("dpkg-deb", "-c", self.deb).stdout.splitlines()}
        self.assertEqual(owners, {"root/root"})


if __name__ == "__main__":
    unittest.main()

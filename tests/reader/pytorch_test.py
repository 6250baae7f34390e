"""TorchPings: tensors of the right type from worker processes. Skips where PyTorch is not."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import small_data
from ensonify_dataset import Display, SonarDataset, normalise

try:
    import torch
    from torch.utils.data import DataLoader, Dataset
    from ensonify_dataset.pytorch import TorchPings
except ImportError:
    torch = None


def halved(sample, ping):
    """A transform: at module level, so that any kind of worker can have it."""
    sample["image"] = normalise(sample["image"])[:, ::2]
    sample["series"] = ping.series
    sample["seen"] = sample["semantic"] > 0
    return sample


@unittest.skipIf(torch is None, "no PyTorch")
class Torch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        cls.data = SonarDataset(small_data.generate(
            "random_debris", cls.folder / "d", "--set", "sequences=6", "--set", "trajectory.pings=1"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def loaded(self, dataset, **options):
        torch.set_num_threads(1)
        return list(DataLoader(dataset, batch_size=2, num_workers=2, **options))

    def test_batches_from_two_workers_hold_the_pings_in_order(self):
        pings = TorchPings(self.data, inputs=("level_db", "clean_db", "grey"),
                           targets=("instance", "semantic", "elevation_rad"))
        self.assertIsInstance(pings, Dataset)
        batches = self.loaded(pings)
        self.assertEqual(torch.cat([b["sequence"] for b in batches]).tolist(), list(range(6)))
        for number, batch in enumerate(batches):
            for row in range(2):
                view = self.data[2 * number + row].polar
                np.testing.assert_array_equal(batch["image"][row].numpy(),
                                              np.stack([view.level_db, view.clean_db, view.grey]))
                for name in ("instance", "semantic", "elevation_rad"):
                    np.testing.assert_array_equal(batch[name][row].numpy(), getattr(view, name))
            self.assertEqual([batch[name].dtype for name in ("image", "instance", "semantic", "elevation_rad")],
                             [torch.float32, torch.int64, torch.int64, torch.float32])

    def test_transforms_run_in_workers_of_either_kind(self):
        pings = TorchPings(self.data, view="polar", transform=halved)
        for kind in ("fork", "spawn"):
            batch = self.loaded(pings, multiprocessing_context=kind)[1]
            ping = self.data[3]
            np.testing.assert_array_equal(batch["image"][1, 0].numpy(), normalise(ping.polar.level_db)[::2])
            np.testing.assert_array_equal(batch["series"][1].numpy(), ping.series)
            self.assertEqual((batch["series"].dtype, batch["seen"].dtype), (torch.complex64, torch.bool))

    def test_masks_go_into_a_loss_as_they_are(self):
        pings = TorchPings(self.data, view="cartesian", inputs=("grey",))
        batch = self.loaded(pings, shuffle=True)[0]
        answer = torch.zeros(2, len(self.data.classes) + 1, *batch["semantic"].shape[1:])
        loss = torch.nn.functional.cross_entropy(answer, batch["semantic"])
        self.assertAlmostEqual(loss.item(), np.log(len(self.data.classes) + 1), places=5)

    def test_normals_are_three_channels(self):
        folder = small_data.generate("random_debris", self.folder / "normals", "--set", "sequences=1",
                                     "--set", "trajectory.pings=1", "--set", "output.surfaces=true")
        data = SonarDataset(folder)
        image = TorchPings(data, inputs=("level_db", "surface_normal"))[0]["image"]
        self.assertEqual(tuple(image.shape), (4, *data[0].polar.level_db.shape))
        np.testing.assert_array_equal(image[2].numpy(), data[0].polar.surface_normal[..., 1])

    def test_wrong_names_are_refused_at_once(self):
        with self.assertRaisesRegex(ValueError, "no array 'level'"):
            TorchPings(self.data, inputs=("level",))
        with self.assertRaisesRegex(ValueError, "polar or cartesian"):
            TorchPings(self.data, view="png")

    def test_grey_comes_from_a_render_or_from_a_display(self):
        """Protects training on another display: the same values, stored or made on the fly."""
        done = subprocess.run([small_data.PROGRAM, "render", self.data.folder, "--name", "a", "--db", "70:130", "--tvg",
                               "20", "--quiet", "--overwrite"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        display = Display((70, 130), spreading=20)
        stored = TorchPings(self.data, inputs=("grey",), targets=(), render="a")[3]["image"]
        made = TorchPings(self.data, inputs=("grey",), targets=(), display=display)[3]["image"]
        plain = TorchPings(self.data, inputs=("grey",), targets=())[3]["image"]
        self.assertTrue(torch.equal(stored, made))
        self.assertFalse(torch.equal(stored, plain))
        with self.assertRaisesRegex(ValueError, "one of them"):
            TorchPings(self.data, inputs=("grey",), render="a", display=display)
        coarse = Display((70, 130), samples=2)
        self.assertEqual(TorchPings(self.data, inputs=("grey",), targets=(), display=coarse)[3]["image"].shape[1],
                         -(-made.shape[1] // 2))
        with self.assertRaisesRegex(ValueError, "differ in size"):
            TorchPings(self.data, inputs=("grey",), display=coarse)[3]
        with self.assertRaisesRegex(ValueError, "not asked for"):
            TorchPings(self.data, inputs=("level_db",), render="a")


if __name__ == "__main__":
    unittest.main()

"""Streams for PyTorch: the same items for any number of workers, positions, splits, and workers that die."""
import os
import signal
import time
import unittest
from unittest import mock

try:
    import torch
    from torch.utils.data import DataLoader
except ImportError:
    torch = None

import ensonify as en
from small_data import SCENES

SMALL = {"sonar.beams.count": 16, "sonar.rays.elevation": 12, "sonar.range_max_m": 3, "output.cartesian": False}


def stream(pings=2, **more):
    from ensonify.torch import SonarStream
    scenario = en.Scenario.load(SCENES / "random_debris.yaml", set={**SMALL, "trajectory.pings": pings})
    return SonarStream(scenario, **{"want": ["level_db", "semantic"], **more})


def add_sum(sample, ping):
    sample["sum"] = sample["level_db"].sum()
    return sample


class Dying:
    """A transform that kills its worker at a sequence."""

    def __call__(self, sample, ping):
        if ping.sequence.number == 4:
            os.kill(os.getpid(), signal.SIGKILL)
        return sample


def raise_value_error(sample, ping):
    raise ValueError("of the user")


def taken(loader, count=None):
    """(sequence, ping, bytes of the level) of each item."""
    items = []
    for item in loader:
        items.append((int(item["sequence"]), int(item["ping"]), item["level_db"].numpy().tobytes()))
        if len(items) == count:
            break
    return items


@unittest.skipIf(torch is None, "no PyTorch")
class Torch(unittest.TestCase):
    def test_items_are_tensors_of_the_ping(self):
        item = next(iter(stream(transform=add_sum)))
        self.assertEqual((item["level_db"].dtype, item["semantic"].dtype), (torch.float32, torch.int64))
        ping = stream().scenario.ping(0, 0)
        self.assertTrue((item["level_db"].numpy() == ping.polar.level_db).all())
        self.assertTrue((item["semantic"].numpy() == ping.polar.semantic).all())
        self.assertAlmostEqual(float(item["sum"]), float(ping.polar.level_db.sum()), delta=1)

    def test_workers_change_nothing(self):
        # 8 sequences of 2 pings, 4 lanes: all run out at once.
        alone = taken(stream(sequences=8))
        self.assertEqual([item[:2] for item in alone[:6]], [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1)])
        self.assertEqual(sorted(item[:2] for item in alone), [(s, p) for s in range(8) for p in range(2)])
        self.assertEqual(taken(stream(sequences=8, threads=1, ahead=1)), alone)
        self.assertEqual(taken(stream(sequences=8, threads=3, ahead=20)), alone)
        for workers in (1, 2, 4):
            loader = DataLoader(stream(sequences=8), batch_size=None, num_workers=workers,
                                multiprocessing_context="spawn")
            self.assertEqual(taken(loader), alone, f"{workers} workers")
        with self.assertRaisesRegex(ValueError, "lanes"):
            taken(DataLoader(stream(), batch_size=None, num_workers=3, multiprocessing_context="spawn"), 1)

    def test_batches_come_whole(self):
        batches = list(stream(sequences=8, batch_size=2))
        self.assertEqual([b["sequence"].tolist() for b in batches[:5]], [[0, 0], [1, 1], [2, 2], [3, 3], [4, 4]])
        self.assertEqual(tuple(batches[0]["level_db"].shape[:1]), (2,))

    def test_a_lane_that_ends_leaves_no_part_of_a_batch(self):
        # Pings of the lanes: 10, 10, 8, 8.
        batches = [b["sequence"].tolist() for b in stream(sequences=18, batch_size=4)]
        self.assertEqual(batches[:4], [[lane, lane, lane + 4, lane + 4] for lane in range(4)])
        self.assertEqual(batches[4:], [[lane + 8, lane + 8, lane + 12, lane + 12] for lane in range(4)])

    def test_two_batches_are_made_before_they_are_taken(self):
        streams = []

        class Kept(en.Stream):
            def __init__(self, *arguments):
                super().__init__(*arguments)
                streams.append(self)

        cores = os.cpu_count()
        for more, ready in (({}, 2 * max(cores, 4)), ({"threads": 5}, 10), ({"ahead": 3}, 3)):
            with mock.patch("ensonify.torch.Stream", Kept):
                batches = iter(stream(batch_size=4, pings=1, **more))
                next(batches)
            while not streams[-1]._core.is_resting:
                time.sleep(0.01)
            self.assertEqual(streams[-1].ready, ready, more)

    def test_a_position_goes_on_where_it_was(self):
        alone = taken(stream(sequences=12))
        for count in (1, 5, 8, 13):
            first = stream(sequences=12)
            self.assertEqual(taken(first, count), alone[:count])
            again = stream(sequences=12)
            again.load_state_dict(first.state_dict())
            self.assertEqual(taken(again), alone[count:], count)
        for workers in (2, 4):
            again = stream(sequences=12)
            again.load_state_dict(again.state_dict(taken=5))
            loader = DataLoader(again, batch_size=None, num_workers=workers, multiprocessing_context="spawn")
            self.assertEqual(taken(loader, 12), alone[5:17])

    def test_a_position_within_a_split(self):
        alone = taken(stream(split="train", sequences=40))
        again = stream(split="train", sequences=40)
        again.load_state_dict({"taken": 6})
        self.assertEqual(taken(again), alone[6:])

    def test_no_world_is_in_two_splits(self):
        worlds = {split: {item[0] for item in taken(stream(split=split, sequences=60, want=["level_db"]))}
                  for split in ("train", "val", "test")}
        self.assertFalse(worlds["train"] & worlds["val"] or worlds["train"] & worlds["test"]
                         or worlds["val"] & worlds["test"])
        self.assertEqual(set.union(*worlds.values()), set(range(60)))

    def test_a_worker_that_is_killed_ends_the_loader(self):
        loader = DataLoader(stream(transform=Dying()), batch_size=None, num_workers=2, multiprocessing_context="spawn")
        # PyTorch says that a worker was killed, or fails to fetch a tensor that the worker had sent before.
        with self.assertRaisesRegex((RuntimeError, ConnectionError), "worker|Connection|connect"):
            taken(loader, 100)

    def test_an_exception_of_a_transform_comes_through(self):
        loader = DataLoader(stream(transform=raise_value_error), batch_size=None, num_workers=2,
                            multiprocessing_context="spawn")
        with self.assertRaisesRegex(ValueError, "of the user"):
            taken(loader, 1)

    def test_a_forked_worker_after_a_world_says_what_to_do(self):
        scene = stream()
        next(iter(scene))
        with self.assertRaisesRegex(RuntimeError, "spawn"):
            taken(DataLoader(stream(), batch_size=None, num_workers=1, multiprocessing_context="fork"), 1)


if __name__ == "__main__":
    unittest.main()

"""Pings without files of the scenes that equality_test.py leaves out."""
import unittest

from equality_test import Comparison
from small_data import other_scenes


class OtherScenes(Comparison):
    def test_scenes_are_the_same_with_and_without_files(self):
        self.compare_scenes(other_scenes())


if __name__ == "__main__":
    unittest.main()

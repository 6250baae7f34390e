"""The reader on the scenes that reader_test.py leaves out."""
import unittest

import reader_test
import small_data


class OtherScenes(reader_test.SceneFiles):
    def test_they_are_read_as_their_files(self):
        self.compare(small_data.other_scenes())


if __name__ == "__main__":
    unittest.main()

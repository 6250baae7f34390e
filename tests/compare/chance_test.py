"""How often statistics differ by chance, in as many pairs of data sets as show it, and by changes."""
import unittest

import program_test


class Chance(program_test.DataSets):
    def test_one_statistic_in_twenty_differs(self):
        # In 3 pairs of 38 statistics 5.7 are expected, with a standard error of 2.3 were they independent.
        self.assertLess(self.equal_scenes(3), 13)

    def test_changes_of_a_tenth_are_found(self):
        self.changes_are_found("bandwidth", "noise")


if __name__ == "__main__":
    unittest.main()

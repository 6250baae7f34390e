"""How often statistics of equal scenes differ: as often as the 95 % of their intervals say."""
import unittest

import program_test


class Chance(program_test.DataSets):
    def test_one_statistic_in_twenty_differs(self):
        # In 3 pairs of 28 statistics 4.2 are expected, with a standard error of 2.0 were they independent.
        self.assertLess(self.equal_scenes(3), 13)


if __name__ == "__main__":
    unittest.main()

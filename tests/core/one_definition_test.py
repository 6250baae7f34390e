"""No two types of namespace ensonify share a name.

Two structs of one name in two folders compile and link. The linker then takes one folder's std::vector of it for the
other's, which writes past the end of the smaller one; clang's address sanitizer found that once.
"""
import collections
import pathlib
import re
import unittest

GENERATOR = pathlib.Path(__file__).resolve().parents[2] / "generator"
TYPE = re.compile(r"^(?:struct|class|enum class|enum)\s+(?:\[\[\w+\]\]\s+)?(\w+)(?:\s+final)?\s*(?::[^:].*)?\{", re.M)


class OneDefinition(unittest.TestCase):
    def test_headers_define_a_name_once(self):
        places = collections.defaultdict(set)
        for header in GENERATOR.rglob("*.h"):
            for name in TYPE.findall(header.read_text()):
                places[name].add(str(header.relative_to(GENERATOR)))
        self.assertGreater(len(places), 300)
        self.assertEqual({name: sorted(p) for name, p in places.items() if len(p) > 1}, {})


if __name__ == "__main__":
    unittest.main()

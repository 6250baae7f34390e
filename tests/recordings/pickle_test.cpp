// Pickles by hand: what only the parser shows, and what no set of NumPy holds.
#include "recordings/pickle.h"

#include "catch.h"
#include "results.h"

using namespace ensonify;

namespace {

// Protocol 2, with "k" for the key of the only value.
std::string pickled(const std::string& value) {
  return "\x80\x02}X" + std::string("\1\0\0\0k", 5) + value + "s.";
}

std::string array_of(const std::string& sides, const std::string& type, const std::string& order,
                     const std::string& fortran, const std::string& data) {
  const auto short_text = [](const std::string& text) {
    return "U" + std::string(1, static_cast<char>(text.size())) + text;
  };
  return "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n" +
         std::string("K\0\x85U\1btR(K\1", 11) + sides + "cnumpy\ndtype\n(" + short_text(type) +
         std::string("K\0K\1tR(K\3", 9) + short_text(order) +
         "NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xff" + std::string("K\0tb", 4) + fortran +
         short_text(data) + "tb";
}

std::string error_of(const std::string& bytes) { return message_of(unpickle_arrays(bytes)); }

}  // namespace

// Protects arrays as Python 2 wrote them: texts and bytes of one type.
TEST_CASE("arrays of Python 2 are read, in either order", "[pickle]") {
  const std::string sides("K\2K\3\x86", 5), data("\0\1\0\2\0\3\0\4\0\5\1\0", 12);
  const auto bytes = pickled(array_of(sides, "u2", ">", "\x89", data));
  const auto found = value_of(unpickle_arrays(bytes));
  const UnpickledArray& array = found.arrays.at("k");
  CHECK(array.shape == std::vector<std::uint64_t>{2, 3});
  CHECK(values_of(array) == std::vector<double>{1, 2, 3, 4, 5, 256});
  const auto columns = pickled(array_of(sides, "u2", ">", "\x88", data));
  const auto turned = value_of(unpickle_arrays(columns));
  CHECK(values_of(turned.arrays.at("k")) == std::vector<double>{1, 3, 5, 2, 4, 256});
}

// Protects memory: sides whose product overflows, and sides that the data do not fill.
TEST_CASE("sides that do not fit the data are refused", "[pickle]") {
  const std::string huge = std::string("\x8a\x08\0\0\0\0\0\0\0\x40", 10);
  const std::string wrap = std::string("\x8a\x08\4\0\0\0\0\0\0\x40", 10);
  for (const std::string& sides :
       {huge + huge + "\x86", wrap + "K\4\x86", std::string("K\2K\2\x86"), huge + "\x85",
        std::string("J\xff\xff\xff\xff\x85")}) {
    const std::string error = error_of(pickled(array_of(sides, "f4", "<", "\x89", "abcd")));
    CHECK_FALSE(error.empty());
  }
  CHECK(error_of(pickled(array_of("K\1\x85", "f4", "<", "\x89", "abcd"))).empty());
  CHECK(contains(error_of(pickled(array_of("K\1\x85", "O8", "<", "\x89", "abcd"))), "type O8"));
}

// Protects time: a key of megabytes that is recalled for each of thousands of values.
TEST_CASE("arrays with long keys are left out", "[pickle]") {
  const auto keys_of = [](std::size_t length) {
    const std::string count{static_cast<char>(length & 255), static_cast<char>(length >> 8), '\0',
                            '\0'};
    const auto found =
        value_of(unpickle_arrays("\x80\x02}X" + count + std::string(length, 'k') +
                                 array_of("K\1\x85", "f4", "<", "\x89", "abcd") + "s."));
    return found.arrays.size();
  };
  CHECK(keys_of(64) == 1);
  CHECK(keys_of(65) == 0);
}

// Protects against cycles and against values that grow by repetition.
TEST_CASE("cycles are harmless and encoded text is limited", "[pickle]") {
  CHECK(error_of("\x80\x02}q" + std::string("\0X\1\0\0\0kh\0s.", 11)).empty());
  std::string bomb = "\x80\x02}c_codecs\nencode\nq" + std::string("\1X\4\0\0\0aaaaq\2", 12) +
                     std::string("X\6\0\0\0latin1q\3", 13);
  for (int i = 0; i < 20'000; ++i) bomb += "h\1h\2h\3\x86R";
  CHECK(contains(error_of(bomb + "."), "more than 65536 values"));
  std::string text(1000, 'a');
  std::string longer = "\x80\x02}c_codecs\nencode\nq" + std::string("\1X\xe8\3\0\0", 6) + text +
                       "q\2" + std::string("X\6\0\0\0latin1q\3", 13);
  for (int i = 0; i < 100; ++i) longer += "h\1h\2h\3\x86R";
  CHECK(contains(error_of(longer + "."), "more text than it has"));
}

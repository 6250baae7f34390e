#include "bench/machine.h"

#include <cmath>
#include <complex>
#include <cstring>
#include <string>
#include <vector>

#include "bench/kernels.h"
#include "catch.h"
#include "core/random.h"
#include "formats/files.h"

using namespace ensonify;

namespace fs = std::filesystem;

TEST_CASE("the median is the middle, the lower one of two") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2);
  CHECK(median({5}) == 5);
}

// Protects against medians of one run: three count at least, and what comes after each is called.
TEST_CASE("a thing is run three times or more, however long it takes") {
  int runs = 0, cleaned = 0;
  median_ms(
      0, [&] { ++runs; }, [&] { ++cleaned; });
  CHECK(runs >= 3);
  CHECK(cleaned == runs);
}

// Protects the figure of the disk: whole pages are written past the cache, and yet the file is the
// one that was asked for.
TEST_CASE("a file on the disk holds what was given, whatever its length") {
  auto folder = ScratchFolder::make(fs::temp_directory_path());
  REQUIRE(folder.ok());
  for (const std::size_t size : {std::size_t{1}, std::size_t{4096}, std::size_t{70'001}}) {
    const PageBuffer buffer(size);
    for (std::size_t i = 0; i < size; ++i) buffer.data()[i] = static_cast<char>(i % 251);
    bool direct = false;
    const fs::path file = folder->path() / "file";
    REQUIRE(write_to_disk(file, buffer.data(), size, direct).ok());
    const auto bytes = read_file(file);
    REQUIRE(bytes.ok());
    CHECK(*bytes == std::string_view(buffer.data(), size));
  }
}

TEST_CASE("a scratch folder takes its files with it, and needs a place") {
  fs::path path;
  {
    auto folder = ScratchFolder::make(fs::temp_directory_path());
    REQUIRE(folder.ok());
    path = folder->path();
    REQUIRE(write_file_atomically(path, "a/b", "text").ok());
  }
  CHECK_FALSE(fs::exists(path));
  const auto nowhere = ScratchFolder::make("/nonexistent/place");
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().kind == ErrorKind::io);
}

namespace {

using Complex = std::complex<double>;

constexpr std::uint64_t kKey = 5;

double draw(std::uint64_t item, std::uint32_t which) { return uniform(kKey, 0, item, which); }

std::uint64_t random_turns(std::uint64_t item, std::uint32_t which) {
  const Philox4 words = random_words(kKey, 0, item, which);
  return std::uint64_t{words.v[0]} << 32 | words.v[1];
}

Complex phasor(std::uint64_t turns) {
  return std::polar(1.0, 2 * kPi * std::ldexp(static_cast<double>(turns), -64));
}

struct Sum {
  std::vector<std::uint64_t> start, step;
  std::vector<float> magnitude;
  int bins = 0;
};

// Magnitudes over three decades; numbers of scatterers and bins that fill no vector.
Sum random_sum(int count, int bins) {
  Sum sum;
  sum.bins = bins;
  for (int i = 0; i < count; ++i) {
    sum.start.push_back(random_turns(i, 0));
    sum.step.push_back(random_turns(i, 1));
    sum.magnitude.push_back(static_cast<float>(std::pow(10, 3 * draw(i, 2))));
  }
  return sum;
}

// Every turn worked out in whole numbers, every phasor by the library in double precision.
std::vector<Complex> summed_in_double(const Sum& sum) {
  std::vector<Complex> all(sum.bins);
  for (int m = 0; m < sum.bins; ++m) {
    for (std::size_t i = 0; i < sum.start.size(); ++i) {
      const std::uint64_t turns = sum.start[i] + static_cast<std::uint64_t>(m) * sum.step[i];
      all[m] += static_cast<double>(sum.magnitude[i]) * phasor(turns);
    }
  }
  return all;
}

template <class Part>
double relative_error(const std::vector<Part>& re, const std::vector<Part>& im,
                      const std::vector<Complex>& exact) {
  double wrong = 0, whole = 0;
  for (std::size_t m = 0; m < exact.size(); ++m) {
    wrong += std::norm(Complex(re[m], im[m]) - exact[m]);
    whole += std::norm(exact[m]);
  }
  return std::sqrt(wrong / whole);
}

template <class Body>
void for_each_level(Body&& body) {
  const KernelList list = supported_kernels();
  for (int i = 0; i < list.count; ++i) {
    INFO(list.table[i]->level);
    body(*list.table[i]);
  }
}

}  // namespace

// Protects the comparison: a reference that gave wrong numbers could be as fast as it likes.
TEST_CASE("both plain sums are those of a double direct sum, on every level") {
  const Sum sum = random_sum(37, 1001);
  const std::vector<Complex> exact = summed_in_double(sum);
  for_each_level([&](const KernelTable& kernels) {
    for (const auto kernel : {kernels.direct, kernels.recurrence}) {
      std::vector<float> re(padded_bins(sum.bins)), im(re), workspace(2 * sum.start.size());
      kernel({sum.start.data(), sum.step.data(), sum.magnitude.data(),
              static_cast<int>(sum.start.size()), sum.bins, re.data(), im.data(),
              workspace.data()});
      CHECK(relative_error(re, im, exact) < 1e-5);
    }
  });
}

// Protects the zero of the fold: an empty sector must give silence, not what was there before.
TEST_CASE("a sum over nothing is zero") {
  for_each_level([&](const KernelTable& kernels) {
    for (const auto kernel : {kernels.direct, kernels.recurrence}) {
      std::vector<float> re(padded_bins(100), 7.0f), im(re);
      kernel({nullptr, nullptr, nullptr, 0, 100, re.data(), im.data(), nullptr});
      for (int m = 0; m < 100; ++m) CHECK((re[m] == 0 && im[m] == 0));
    }
  });
}

// Protects the errors that the bench reports: what they are measured against is exact to many more
// digits than any of them has.
TEST_CASE("the exact sum is good to 1e-12") {
  const Sum sum = random_sum(23, 2501);
  const std::vector<Complex> exact = summed_in_double(sum);
  std::vector<double> start_re, start_im, step_re, step_im;
  for (std::size_t i = 0; i < sum.start.size(); ++i) {
    const Complex start = static_cast<double>(sum.magnitude[i]) * phasor(sum.start[i]);
    start_re.push_back(start.real());
    start_im.push_back(start.imag());
    step_re.push_back(phasor(sum.step[i]).real());
    step_im.push_back(phasor(sum.step[i]).imag());
  }
  for_each_level([&](const KernelTable& kernels) {
    std::vector<double> re(padded_bins(sum.bins)), im(re);
    kernels.exact({start_re.data(), start_im.data(), step_re.data(), step_im.data(),
                   static_cast<int>(sum.start.size()), sum.bins, re.data(), im.data()});
    CHECK(relative_error(re, im, exact) < 1e-12);
  });
}

TEST_CASE("shaping multiplies the conjugate by the pulse") {
  const int count = 45;
  std::vector<float> part[4];
  for (int p = 0; p < 4; ++p) {
    for (int m = 0; m < count; ++m) part[p].push_back(static_cast<float>(draw(m, p) - 0.5));
  }
  for_each_level([&](const KernelTable& kernels) {
    std::vector<std::complex<float>> out(count);
    kernels.shape({part[0].data(), part[1].data(), part[2].data(), part[3].data(), count,
                   reinterpret_cast<float*>(out.data())});
    for (int m = 0; m < count; ++m) {
      const Complex expected =
          std::conj(Complex(part[0][m], part[1][m])) * Complex(part[2][m], part[3][m]);
      CHECK(std::abs(Complex(out[m]) - expected) < 1e-6);
    }
  });
}

// Protects the full product where beams fill no block of rows: nothing is written behind the last
// beam, and no beam is left out.
TEST_CASE("the full product is that of a double one, on every level") {
  const int beams = 21;
  for_each_level([&](const KernelTable& kernels) {
    const int rows = kernels.mix_rows, stride = 3 * kernels.mix_columns;
    std::vector<float> in, weights((beams + rows - 1) / rows * rows * beams);
    for (int k = 0; k < beams * stride; ++k) in.push_back(static_cast<float>(draw(k, 0) - 0.5));
    const auto weight = [](int i, int j) { return static_cast<float>(draw(i * 100 + j, 1) - 0.5); };
    for (int j = 0; j < beams; ++j) {
      for (int i = 0; i < beams; ++i)
        weights[(j / rows * beams + i) * rows + j % rows] = weight(i, j);
    }
    std::vector<float> out((beams + 1) * stride, 9.0f), workspace(beams * kernels.mix_columns);
    for (int first = 0; first < stride; first += kernels.mix_columns) {
      kernels.mix({weights.data(), in.data(), out.data(), beams, stride, first, workspace.data()});
    }
    for (int j = 0; j < beams; ++j) {
      for (int c = 0; c < stride; ++c) {
        double expected = 0;
        for (int i = 0; i < beams; ++i) expected += weight(i, j) * double(in[i * stride + c]);
        REQUIRE(std::abs(out[j * stride + c] - expected) < 1e-5);
      }
    }
    for (int c = 0; c < stride; ++c) REQUIRE(out[beams * stride + c] == 9.0f);
  });
}

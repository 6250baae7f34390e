#include "dataset/deflate.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

static_assert(std::endian::native == std::endian::little, "bits are stored eight bytes at once");

namespace ensonify {
namespace {

// Codes are fitted to one block at a time. No block has more tokens than this.
constexpr std::size_t kBlockBytes = std::size_t{1} << 16;
constexpr int kSymbols = 286;  // literals, end of block, lengths
constexpr int kEndOfBlock = 256;
constexpr int kMaxCodeBits = 15;
constexpr std::size_t kMinRun = 4, kMaxMatch = 258;

struct Code {
  std::uint32_t bits = 0;
  int length = 0;
};

struct LengthSymbol {
  int symbol, extra_bits, first;
};

// RFC 1951, 3.2.5.
LengthSymbol length_symbol(int length) {
  if (length == 258) return {285, 0, 258};
  if (length < 11) return {254 + length, 0, length};
  const int offset = length - 3;
  const int extra = std::bit_width(static_cast<unsigned>(offset)) - 3;
  return {261 + 4 * (extra - 1) + (offset >> extra), extra, (offset >> extra << extra) + 3};
}

class BitWriter {
 public:
  explicit BitWriter(std::string& out) : out_(out), used_(out.size()) {}

  // Call before every 2 * kBlockBytes of output at most.
  void reserve(std::size_t bytes) {
    if (out_.size() < used_ + bytes) out_.resize(used_ + bytes);
  }
  // Up to 32 bits, lowest first.
  void put(std::uint32_t bits, int count) {
    pending_ |= std::uint64_t{bits} << pending_bits_;
    pending_bits_ += count;
    if (pending_bits_ < 32) return;
    const auto word = static_cast<std::uint32_t>(pending_);
    std::memcpy(out_.data() + used_, &word, sizeof word);
    used_ += sizeof word;
    pending_ >>= 32;
    pending_bits_ -= 32;
  }
  void finish() {
    for (; pending_bits_ > 0; pending_bits_ -= 8, pending_ >>= 8) {
      out_[used_++] = static_cast<char>(pending_ & 255);
    }
    out_.resize(used_);
  }

 private:
  std::string& out_;
  std::size_t used_;
  std::uint64_t pending_ = 0;
  int pending_bits_ = 0;
};

// How many bytes from `at` on equal the byte before them.
std::size_t run_length(const std::uint8_t* at, std::size_t limit) {
  std::size_t length = 0;
  for (; length + 8 <= limit; length += 8) {
    std::uint64_t here, before;
    std::memcpy(&here, at + length, 8);
    std::memcpy(&before, at + length - 1, 8);
    if (here != before) {
      return length + static_cast<std::size_t>(std::countr_zero(here ^ before)) / 8;
    }
  }
  while (length < limit && at[length] == at[length - 1]) ++length;
  return length;
}

// Literals as they are, a match as 256 + its length.
using Tokens = std::vector<std::uint16_t>;

void tokenize(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end,
              Tokens& tokens) {
  tokens.resize(end - begin);
  std::uint16_t* out = tokens.data();
  const std::uint8_t* data = bytes.data();
  std::size_t i = begin;
  if (i == 0) *out++ = data[i++];
  while (i < end) {
    std::uint32_t here = 0, before = 1;
    if (i + kMinRun <= end) {
      std::memcpy(&here, data + i, 4);
      std::memcpy(&before, data + i - 1, 4);
    }
    if (here != before) {
      *out++ = data[i++];
      continue;
    }
    for (std::size_t left = run_length(data + i, end - i); left > 0;) {
      const std::size_t length = left < kMinRun ? 1 : std::min(left, kMaxMatch);
      *out++ = static_cast<std::uint16_t>(length == 1 ? data[i] : 256 + length);
      i += length;
      left -= length;
    }
  }
  tokens.resize(static_cast<std::size_t>(out - tokens.data()));
}

using Counts = std::array<std::uint32_t, kSymbols>;
using Codes = std::array<Code, kSymbols>;

// Lengths of the Huffman code; 0 for symbols that do not occur. Needs two that do. Returns the
// longest.
int fit_lengths(const Counts& counts, Codes& codes) {
  struct Node {
    std::uint32_t count;
    int symbol;
  };
  std::vector<Node> nodes;
  for (int s = 0; s < kSymbols; ++s) {
    if (counts[s] > 0) nodes.push_back({counts[s], s});
  }
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) {
    return a.count != b.count ? a.count < b.count : a.symbol < b.symbol;
  });
  // Leaves in order, then the inner nodes, which come about in order as well.
  const std::size_t leaves = nodes.size();
  std::vector<std::size_t> parent(2 * leaves - 1);
  std::size_t leaf = 0, inner = leaves;
  while (nodes.size() < 2 * leaves - 1) {
    std::uint32_t count = 0;
    for (int child = 0; child < 2; ++child) {
      const bool take_leaf =
          leaf < leaves && (inner == nodes.size() || nodes[leaf].count <= nodes[inner].count);
      const std::size_t taken = take_leaf ? leaf++ : inner++;
      count += nodes[taken].count;
      parent[taken] = nodes.size();
    }
    nodes.push_back({count, -1});
  }
  std::vector<int> depth(nodes.size(), 0);
  for (auto n = nodes.size() - 1; n-- > 0;) depth[n] = depth[parent[n]] + 1;
  for (std::size_t n = 0; n < leaves; ++n) codes[nodes[n].symbol].length = depth[n];
  return *std::max_element(depth.begin(), depth.end());
}

// RFC 1951, 3.2.2; the codes' bits reversed, as they are written.
Codes fit_codes(Counts counts) {
  Codes codes{};
  while (fit_lengths(counts, codes) > kMaxCodeBits) {
    for (auto& count : counts) count = (count + 1) / 2;
  }
  std::uint32_t next = 0;
  for (int length = 1; length <= kMaxCodeBits; ++length, next <<= 1) {
    for (Code& code : codes) {
      if (code.length != length) continue;
      for (int bit = 0; bit < length; ++bit) code.bits |= (next >> bit & 1) << (length - 1 - bit);
      ++next;
    }
  }
  return codes;
}

// The lengths stand in a code of their own, in which all of 0 to 15 have four bits: 140 bytes.
void put_codes(BitWriter& writer, const Codes& codes, bool last) {
  writer.put(last ? 1 : 0, 1);
  writer.put(2, 2);
  writer.put(kSymbols - 257, 5);
  writer.put(0, 5);   // one distance
  writer.put(15, 4);  // 19 lengths of code lengths, of which the first three are not used
  for (int i = 0; i < 19; ++i) writer.put(i < 3 ? 0 : 4, 3);
  const auto put_length = [&](int length) {
    const auto n = static_cast<unsigned>(length);
    writer.put((n & 1) << 3 | (n & 2) << 1 | (n & 4) >> 1 | (n & 8) >> 3, 4);
  };
  for (const Code& code : codes) put_length(code.length);
  put_length(1);  // of the distance 1
}

void put_block(BitWriter& writer, const Tokens& tokens, bool last) {
  std::array<std::uint32_t, 256 + kMaxMatch + 1> token_counts{};
  for (const std::uint16_t token : tokens) ++token_counts[token];
  Counts counts{};
  std::copy_n(token_counts.begin(), 256, counts.begin());
  counts[kEndOfBlock] = 1;
  if (tokens.empty()) counts[0] = 1;  // a code has two symbols at least
  for (int n = 3; n <= static_cast<int>(kMaxMatch); ++n) {
    counts[length_symbol(n).symbol] += token_counts[256 + n];
  }
  const Codes codes = fit_codes(counts);
  put_codes(writer, codes, last);

  std::array<Code, 256 + kMaxMatch + 1> token_codes;
  std::copy_n(codes.begin(), 256, token_codes.begin());
  for (int n = 3; n <= static_cast<int>(kMaxMatch); ++n) {
    const auto [symbol, extra_bits, first] = length_symbol(n);
    const Code code = codes[symbol];
    // The code of the distance is one bit, 0.
    token_codes[256 + n] = {code.bits | static_cast<std::uint32_t>(n - first) << code.length,
                            code.length + extra_bits + 1};
  }
  for (const std::uint16_t token : tokens) {
    writer.put(token_codes[token].bits, token_codes[token].length);
  }
  writer.put(codes[kEndOfBlock].bits, codes[kEndOfBlock].length);
}

}  // namespace

void append_zlib(std::span<const std::uint8_t> bytes, std::string& out) {
  out += "\x78\x01";
  BitWriter writer(out);
  Tokens tokens;
  std::size_t begin = 0;
  do {
    const std::size_t end = std::min(begin + kBlockBytes, bytes.size());
    tokens.clear();
    if (begin < end) tokenize(bytes, begin, end, tokens);
    writer.reserve(2 * kBlockBytes + 512);
    put_block(writer, tokens, end == bytes.size());
    begin = end;
  } while (begin < bytes.size());
  writer.finish();
  auto sum = static_cast<std::uint32_t>(adler32_z(1, bytes.data(), bytes.size()));
  for (int i = 0; i < 4; ++i, sum <<= 8) out += static_cast<char>(sum >> 24);
}

}  // namespace ensonify

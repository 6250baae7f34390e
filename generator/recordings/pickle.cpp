#include "recordings/pickle.h"

#include <fmt/format.h>

#include <bit>
#include <optional>
#include <utility>

#include "formats/bytes.h"

namespace ensonify {
namespace {

using namespace pickle;

// Of values, pushes and memo entries; a dictionary of ten arrays takes a few hundred.
constexpr std::size_t kMostValues = 1 << 16;
bool is_one_of(std::uint8_t opcode, std::string_view opcodes) {
  return opcodes.find(static_cast<char>(opcode)) != std::string_view::npos;
}

// Runs the opcodes of a pickle. Values refer to each other by number and are never released, so
// that cycles are harmless; number 0 is None. The first fault ends the run.
class Machine {
 public:
  Machine(std::string_view bytes, std::deque<std::string>& decoded)
      : bytes_(bytes), decoded_(decoded), values_(1) {}

  // The value, which is a dictionary. Error: as unpickle_arrays.
  Result<std::uint32_t> run() {
    if (bytes_.size() < 2 || bytes_[0] != '\x80') fail("not a pickle of protocol 2 to 5");
    while (fault_.empty()) {
      start_ = at_;
      const auto opcode = number<std::uint8_t>();
      if (!fault_.empty()) break;
      if (opcode == '.') return stopped();
      const bool known = header(opcode) || numbers(opcode) || texts(opcode) || containers(opcode) ||
                         memo(opcode) || objects(opcode);
      if (!known) {
        fail(
            fmt::format("opcode 0x{:02x}; expected only those of dictionaries, texts, numbers, "
                        "tuples, bytes and NumPy arrays",
                        opcode));
      }
    }
    return fault();
  }

  const PickleValue& value(std::uint32_t number) const { return values_[number]; }

 private:
  Error fault() const { return {ErrorKind::usage, fmt::format("byte {}: {}", start_, fault_)}; }
  void fail(std::string what) {
    if (fault_.empty()) fault_ = std::move(what);
  }

  Result<std::uint32_t> stopped() {
    if (stack_.size() != 1 || !marks_.empty() || values_[stack_[0]].kind != Kind::dict) {
      fail("ends without a dictionary");
      return fault();
    }
    return stack_[0];
  }

  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_) {
      fail("ends here");
      return {};
    }
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  template <class T>
  T number() {
    const std::string_view raw = take(sizeof(T));
    return raw.size() == sizeof(T) ? value_at<T>(raw, 0) : T{};
  }
  std::string_view line() {
    const std::size_t end = bytes_.substr(at_, kLongestGlobal).find('\n');
    if (end == std::string_view::npos) {
      fail("a long name");
      return {};
    }
    const std::string_view text = take(end);
    take(1);
    return text;
  }

  void push(std::uint32_t number) {
    if (++pushes_ > kMostValues) return fail(fmt::format("more than {} values", kMostValues));
    stack_.push_back(number);
  }
  PickleValue& push(Kind kind) {
    push(static_cast<std::uint32_t>(values_.size()));
    values_.push_back({});
    values_.back().kind = kind;
    return values_.back();
  }
  void push_number(std::int64_t number) { push(Kind::number).number = number; }
  // None, with a fault, if there is nothing above the last mark.
  std::uint32_t pop() {
    if (stack_.size() <= (marks_.empty() ? 0 : marks_.back())) {
      fail("takes a value that is not there");
      return 0;
    }
    const std::uint32_t number = stack_.back();
    stack_.pop_back();
    return number;
  }
  std::uint32_t top() {
    const std::uint32_t number = pop();
    if (fault_.empty()) stack_.push_back(number);
    return number;
  }
  // The values above the last mark, which goes.
  std::vector<std::uint32_t> pop_marked() {
    if (marks_.empty()) {
      fail("takes a mark that is not there");
      return {};
    }
    const auto from = stack_.begin() + static_cast<std::ptrdiff_t>(marks_.back());
    std::vector<std::uint32_t> items(from, stack_.end());
    stack_.erase(from, stack_.end());
    marks_.pop_back();
    return items;
  }

  bool header(std::uint8_t opcode) {
    if (opcode == 0x80) {
      const auto protocol = number<std::uint8_t>();
      if (protocol < 2 || protocol > 5) fail(fmt::format("protocol {}; expected 2 to 5", protocol));
      return true;
    }
    if (opcode == 0x95) number<std::uint64_t>();  // a frame is only a hint for buffers
    return opcode == 0x95;
  }

  bool numbers(std::uint8_t opcode) {
    if (opcode == 'N') push(0u);
    if (opcode == 0x88) push_number(1);
    if (opcode == 0x89) push_number(0);
    if (opcode == 'K') push_number(number<std::uint8_t>());
    if (opcode == 'M') push_number(number<std::uint16_t>());
    if (opcode == 'J') push_number(number<std::int32_t>());
    if (opcode == 0x8a) push_number(long_number());
    if (opcode == 'G') push_real();
    return is_one_of(opcode, "N\x88\x89KMJ\x8aG");
  }
  void push_real() {
    take(8);
    push(Kind::real);
  }
  // Two's complement, little-endian.
  std::int64_t long_number() {
    const std::string_view raw = take(number<std::uint8_t>());
    if (raw.size() > 8) fail("an integer of more than 8 bytes");
    std::uint64_t bits = !raw.empty() && (raw.back() & '\x80') != 0 ? ~std::uint64_t{0} : 0;
    for (std::size_t i = std::min<std::size_t>(raw.size(), 8); i-- > 0;) {
      bits = bits << 8 | static_cast<unsigned char>(raw[i]);
    }
    return std::bit_cast<std::int64_t>(bits);
  }

  bool texts(std::uint8_t opcode) {
    const bool is_text = is_one_of(opcode, "\x8cX\x8d");
    if (!is_text && !is_one_of(opcode, "UTCB\x8e\x96")) return false;  // U, T: of Python 2
    const std::uint64_t count = is_one_of(opcode, "\x8cUC") ? number<std::uint8_t>()
                                : is_one_of(opcode, "XTB")  ? number<std::uint32_t>()
                                                            : number<std::uint64_t>();
    const std::string_view text = take(count);
    push(is_text ? Kind::text : Kind::bytes).text = text;
    return true;
  }

  bool containers(std::uint8_t opcode) {
    switch (opcode) {
      case '(':
        if (marks_.size() >= kMostValues) fail("more marks than values");
        marks_.push_back(stack_.size());
        return true;
      case '}':
        push(Kind::dict);
        return true;
      case ')':
        push(Kind::tuple);
        return true;
      case 't':
        push_tuple(pop_marked());
        return true;
      case 0x85:
      case 0x86:
      case 0x87: {
        std::vector<std::uint32_t> items(opcode - 0x84u);
        for (std::size_t i = items.size(); i-- > 0;) items[i] = pop();
        push_tuple(std::move(items));
        return true;
      }
      case 's': {
        const std::uint32_t value = pop(), key = pop();
        set_items({key, value});
        return true;
      }
      case 'u':
        set_items(pop_marked());
        return true;
      default:
        return false;
    }
  }
  void push_tuple(std::vector<std::uint32_t> items) { push(Kind::tuple).items = std::move(items); }
  void set_items(const std::vector<std::uint32_t>& items) {
    PickleValue& dict = values_[top()];
    if (dict.kind != Kind::dict || items.size() % 2 != 0)
      return fail("sets items of no dictionary");
    dict.items.insert(dict.items.end(), items.begin(), items.end());
  }

  bool memo(std::uint8_t opcode) {
    if (opcode == 0x94) keep(static_cast<std::uint32_t>(memo_.size()));
    if (opcode == 'q') keep(number<std::uint8_t>());
    if (opcode == 'r') keep(number<std::uint32_t>());
    if (opcode == 'h') recall(number<std::uint8_t>());
    if (opcode == 'j') recall(number<std::uint32_t>());
    return is_one_of(opcode, "\x94qrhj");
  }
  void keep(std::uint32_t place) {
    if (memo_.size() >= kMostValues) return fail(fmt::format("more than {} values", kMostValues));
    memo_[place] = top();
  }
  void recall(std::uint32_t place) {
    const auto found = memo_.find(place);
    if (found == memo_.end()) return fail("recalls a value that is not there");
    push(found->second);
  }

  bool objects(std::uint8_t opcode) {
    switch (opcode) {
      case 'c': {
        const std::string_view module = line(), name = line();
        push_global(module, name);
        return true;
      }
      case 0x93: {
        const PickleValue &name = values_[pop()], &module = values_[pop()];
        if (name.kind != Kind::text || module.kind != Kind::text) fail("a name that is no text");
        push_global(module.text, name.text);
        return true;
      }
      case 'R':
        reduce();
        return true;
      case 'b':
        build();
        return true;
      default:
        return false;
    }
  }
  void push_global(std::string_view module, std::string_view name) {
    if (!fault_.empty()) return;
    const auto known = global_of(module, name);
    if (!known) {
      return fail(fmt::format("refers to {}.{}, which is not one of NumPy's functions for arrays",
                              printable(module), printable(name)));
    }
    push(Kind::global).global = *known;
  }

  // An item of a tuple; None where there is none.
  const PickleValue& item(const PickleValue& tuple, std::size_t i) const {
    return values_[i < tuple.items.size() ? tuple.items[i] : 0];
  }

  void reduce() {
    const std::uint32_t given = pop(), function = pop();
    if (!fault_.empty()) return;
    const PickleValue& of = values_[given];
    if (of.kind != Kind::tuple || values_[function].kind != Kind::global) {
      return fail("calls what is not a function");
    }
    switch (values_[function].global) {
      case Global::ndarray:
        return fail("calls numpy.ndarray");
      case Global::reconstruct:
        push(Kind::array);
        return;  // build fills it
      case Global::dtype:
        return push_dtype(item(of, 0));
      case Global::encode:
        return push_encoded(item(of, 0), item(of, 1));
      case Global::frombuffer: {
        const PickleValue &data = item(of, 0), &dtype = item(of, 1), &shape = item(of, 2);
        const bool fortran = item(of, 3).text == "F";
        push(Kind::array);
        fill(values_.back(), shape, dtype, fortran, data);
        return;
      }
    }
  }
  void push_dtype(const PickleValue& code) {
    if (!is_text(code) || !is_dtype(code.text)) {
      return fail(fmt::format("an array of type {}; expected floats or integers",
                              is_text(code) ? printable(code.text) : "unknown"));
    }
    push(Kind::dtype).array.dtype = std::string(code.text);
  }
  void push_encoded(const PickleValue& text, const PickleValue& encoding) {
    if (text.kind != Kind::text || (encoding.text != "latin1" && encoding.text != "latin-1")) {
      return fail("encodes text other than by latin1");
    }
    decoded_bytes_ += text.text.size();
    if (decoded_bytes_ > bytes_.size()) return fail("encodes more text than it has");
    auto bytes = latin1_of(text.text);
    if (!bytes) return fail("encodes text that is not latin1");
    decoded_.push_back(std::move(*bytes));
    push(Kind::bytes).text = decoded_.back();
  }

  void build() {
    const std::uint32_t given = pop();
    PickleValue& target = values_[top()];
    const PickleValue& state = values_[given];
    if (!fault_.empty()) return;
    if (state.kind == Kind::tuple && target.kind == Kind::dtype) {
      const PickleValue& order = item(state, 1);
      if (!is_text(order)) return fail("a type without an order of bytes");
      target.array.big_endian = order.text == ">";
      return;
    }
    if (state.kind != Kind::tuple || target.kind != Kind::array || state.items.size() != 5) {
      return fail("a state that is not that of an array");
    }
    fill(target, item(state, 1), item(state, 2), item(state, 3).number != 0, item(state, 4));
  }
  void fill(PickleValue& target, const PickleValue& shape, const PickleValue& dtype, bool fortran,
            const PickleValue& data) {
    auto sides = sides_of(shape);
    if (dtype.kind != Kind::dtype || data.kind != Kind::bytes || !sides) {
      return fail("an array of another kind; expected numbers in C order");
    }
    UnpickledArray array = dtype.array;
    array.shape = std::move(*sides);
    array.fortran_order = fortran;
    array.data = data.text;
    if (!is_consistent(array)) {
      return fail(fmt::format("an array of {} bytes, which its shape and type do not need",
                              data.text.size()));
    }
    target.array = std::move(array);
  }
  // None if they are not numbers from 0.
  std::optional<std::vector<std::uint64_t>> sides_of(const PickleValue& shape) const {
    if (shape.kind != Kind::tuple || shape.items.size() > kMostSides) return std::nullopt;
    std::vector<std::uint64_t> sides;
    for (const std::uint32_t number : shape.items) {
      const PickleValue& side = values_[number];
      if (side.kind != Kind::number || side.number < 0) return std::nullopt;
      sides.push_back(static_cast<std::uint64_t>(side.number));
    }
    return sides;
  }

  std::string_view bytes_;
  std::deque<std::string>& decoded_;
  std::size_t at_ = 0, start_ = 0;  // the next byte; the opcode
  std::deque<PickleValue> values_;        // references stay valid when it grows
  std::vector<std::uint32_t> stack_;
  std::vector<std::size_t> marks_;  // sizes of the stack
  std::map<std::uint32_t, std::uint32_t> memo_;
  std::size_t pushes_ = 0;
  std::uint64_t decoded_bytes_ = 0;
  std::string fault_;
};

}  // namespace

Result<Unpickled> unpickle_arrays(std::string_view bytes) {
  Unpickled found;
  Machine machine(bytes, found.decoded);
  const auto number = machine.run();
  if (!number) return number.error();
  const PickleValue& dict = machine.value(*number);
  for (std::size_t i = 0; i + 1 < dict.items.size(); i += 2) {
    const PickleValue &key = machine.value(dict.items[i]), &value = machine.value(dict.items[i + 1]);
    // A long key that is recalled again and again would be copied as often.
    const bool named =
        (key.kind == Kind::text || key.kind == Kind::bytes) && key.text.size() <= kLongestGlobal;
    // An array that was never filled has no type.
    if (!named || value.kind != Kind::array || value.array.dtype.empty()) continue;
    found.arrays[std::string(key.text)] = value.array;
  }
  return found;
}

}  // namespace ensonify

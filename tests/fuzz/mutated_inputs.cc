#include "tests/fuzz/mutated_inputs.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string_view>

#include "base/check.h"
#include "base/random.h"

namespace muster::fuzz {
namespace {

constexpr std::int64_t kIntegers[] = {
    0,         1,          -1,        2,         INT8_MAX,   INT8_MIN,      UINT8_MAX, INT16_MAX,
    INT16_MIN, UINT16_MAX, INT32_MAX, INT32_MIN, UINT32_MAX, INT32_MAX / 8, INT64_MAX, INT64_MIN};

constexpr double kReals[] = {-0.0,
                             -1,
                             0.5,
                             1e308,
                             -1e308,
                             std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()};

constexpr std::string_view kWords[] = {"0",      "-1",         "1e999",
                                       "-1e999", "1e-999",     "0.1",
                                       "NaN",    "2147483648", "18446744073709551616",
                                       "null",   "true",       "[]",
                                       "{}",     "[[[[",       "\"\"",
                                       "\"a\"",  "\\u0000",    "\\ud800",
                                       ",",      ";",          "\"",
                                       "\n",     "\r\n",       "\xff",
                                       "*",      "|",          "=",
                                       "@",      ":"};

/// One text being changed; every change keeps within a few times the longest allowed.
class Mutator {
 public:
  Mutator(std::string text, const std::vector<std::string>& seeds, std::size_t longest,
          Random* random)
      : text_(std::move(text)), seeds_(seeds), longest_(longest), random_(*random) {}

  std::string Run() && {
    const std::size_t changes = 1 + Below(5);
    for (std::size_t i = 0; i < changes; ++i) {
      Change();
      if (text_.size() > longest_) text_.resize(longest_);
    }
    return std::move(text_);
  }

 private:
  std::size_t Below(std::size_t n) { return random_.Below(static_cast<std::uint32_t>(n)); }
  std::size_t Place() { return Below(text_.size() + 1); }
  /// Of text_: mostly short, at times all that follows.
  std::size_t LengthAt(std::size_t at) {
    const std::size_t rest = text_.size() - at;
    return Below(std::min<std::size_t>(rest, Below(4) == 0 ? rest : 32) + 1);
  }
  template <class T, std::size_t n>
  const T& Pick(const T (&values)[n]) {
    return values[Below(n)];
  }

  void Change() {
    const std::size_t at = Place();
    switch (Below(11)) {
      case 0:  // a bit
        if (at < text_.size()) text_[at] = static_cast<char>(text_[at] ^ (1 << Below(8)));
        return;
      case 1:  // a byte
        if (at < text_.size()) text_[at] = static_cast<char>(Below(256));
        return;
      case 2:
        return Overwrite(at, Bytes(static_cast<std::uint64_t>(Pick(kIntegers)), 1u << Below(4)));
      case 3:
        return Overwrite(at, Bytes(std::bit_cast<std::uint64_t>(Pick(kReals)), 8));
      case 4:
        text_.erase(at, LengthAt(at));
        return;
      case 5:
        text_.insert(Place(), text_.substr(at, LengthAt(at)));
        return;
      case 6:
        return Overwrite(Place(), text_.substr(at, LengthAt(at)));
      case 7: {  // again and again: nesting, long lists, long lines
        const std::string block = text_.substr(at, 1 + Below(4));
        std::string repeated;
        for (std::size_t n = Below(2000); n > 0 && repeated.size() < longest_; --n) {
          repeated += block;
        }
        text_.insert(at, repeated);
        return;
      }
      case 8: {  // goes on as another seed does
        const std::string& other = seeds_[Below(seeds_.size())];
        text_ = text_.substr(0, at) + other.substr(Below(other.size() + 1));
        return;
      }
      case 9: {  // another number in the place of one
        const std::size_t first = text_.find_first_of("0123456789", at);
        if (first == std::string::npos) return Insert(at);
        const std::size_t last = text_.find_first_not_of("+-.eE0123456789", first);
        text_.erase(first, last == std::string::npos ? last : last - first);
        return Insert(first);
      }
      default:
        return Insert(at);
    }
  }

  void Insert(std::size_t at) { text_.insert(at, Pick(kWords)); }

  void Overwrite(std::size_t at, const std::string& bytes) {
    text_.replace(at, std::min(bytes.size(), text_.size() - at), bytes);
  }

  /// The low `n` bytes, high byte first as on the wire, or low byte first.
  std::string Bytes(std::uint64_t value, std::size_t n) {
    std::string bytes;
    for (std::size_t i = 0; i < n; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
    if (Below(4) != 0) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  }

  std::string text_;
  const std::vector<std::string>& seeds_;
  const std::size_t longest_;
  Random& random_;
};

}  // namespace

MutatedInputs::MutatedInputs(std::vector<std::string> seeds, std::uint64_t random_seed,
                             const Limits& limits)
    : seeds_(std::move(seeds)), random_seed_(random_seed), limits_(limits) {
  MUSTER_CHECK(!seeds_.empty());
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    const std::size_t size = seeds_[i].size();
    const std::size_t n = std::min(size, limits_.beginnings);
    for (std::size_t k = 0; k < n; ++k) beginnings_.push_back({i, k * size / n});
  }
  first_mutation_ = seeds_.size() + beginnings_.size();
}

std::string MutatedInputs::At(std::size_t index) const {
  MUSTER_CHECK(index < size(), "{} of {}", index, size());
  if (index < seeds_.size()) return seeds_[index];
  if (index >= first_mutation_) return Mutation(index - first_mutation_);
  const Beginning& beginning = beginnings_[index - seeds_.size()];
  return seeds_[beginning.seed].substr(0, beginning.length);
}

std::string MutatedInputs::Mutation(std::size_t index) const {
  Random random(random_seed_, Stream::kTest, index);
  const std::string& seed = seeds_[random.Below(static_cast<std::uint32_t>(seeds_.size()))];
  return Mutator(seed, seeds_, limits_.longest, &random).Run();
}

}  // namespace muster::fuzz

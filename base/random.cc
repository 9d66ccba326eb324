#include "base/random.h"

#include <Random123/philox.h>

namespace muster {

Random::Random(std::uint64_t seed, Stream stream, std::uint64_t entity, std::uint32_t index)
    : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
      counter_{
          0, (static_cast<std::uint32_t>(stream) << 24) ^ static_cast<std::uint32_t>(entity >> 32),
          static_cast<std::uint32_t>(entity), index} {}

std::uint32_t Random::NextWord() {
  if (next_ == 4) {
    const r123::Philox4x32::ctr_type counter = {
        {counter_[0], counter_[1], counter_[2], counter_[3]}};
    const r123::Philox4x32::key_type key = {{key_[0], key_[1]}};
    const auto block = r123::Philox4x32()(counter, key);
    for (int i = 0; i < 4; ++i) block_[i] = block[static_cast<std::size_t>(i)];
    ++counter_[0];
    next_ = 0;
  }
  return block_[next_++];
}

double Random::Uniform() {
  const std::uint64_t high = NextWord() >> 5;
  const std::uint64_t low = NextWord() >> 6;
  return static_cast<double>((high << 26) | low) * 0x1.0p-53;
}

std::uint32_t Random::Below(std::uint32_t n) {
  std::uint64_t product = std::uint64_t{NextWord()} * n;
  if (static_cast<std::uint32_t>(product) < n) {
    const std::uint32_t threshold = -n % n;
    while (static_cast<std::uint32_t>(product) < threshold) {
      product = std::uint64_t{NextWord()} * n;
    }
  }
  return static_cast<std::uint32_t>(product >> 32);
}

}  // namespace muster

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace muster::fuzz {

/// The inputs of a repeatable run of a fuzzer: its seeds as they are, their beginnings, and seeds
/// changed at random. Which input has which number follows from the arguments alone.
class MutatedInputs {
 public:
  struct Limits {
    std::size_t beginnings = 0;  ///< a seed, evenly spread; every one of a seed that is no longer
    std::size_t mutations = 0;   ///< in all
    std::size_t longest = 0;     ///< bytes of a mutation
  };

  /// `seeds` must not be empty.
  MutatedInputs(std::vector<std::string> seeds, std::uint64_t random_seed, const Limits& limits);

  std::size_t size() const { return first_mutation_ + limits_.mutations; }
  std::string At(std::size_t index) const;

 private:
  std::string Mutation(std::size_t index) const;

  std::vector<std::string> seeds_;
  std::uint64_t random_seed_;
  Limits limits_;
  struct Beginning {
    std::size_t seed, length;
  };
  std::vector<Beginning> beginnings_;
  std::size_t first_mutation_;
};

}  // namespace muster::fuzz

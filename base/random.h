#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace muster {

/// What a random draw is for. The numbers are part of every run's result: never renumber.
enum class Stream : std::uint32_t {
  kTasks = 1,
  kChargingPoints = 2,
  kUavs = 3,
  kWorkers = 4,
  kVehicles = 5,
  kWind = 10,
  kCommunication = 11,
  kAgentFailure = 12,
  kMatchFailure = 13,
  kPolicy = 20,
  kExpectedTasks = 21,
  kPlanSearch = 22,
  kPacketFault = 30,
  kLatency = 31,
  kSoak = 32,
  kClosures = 33,
  kTraining = 40,
  kTest = 99,
};

/// Random numbers that are a function of (seed, stream, entity, index) and never of history: any
/// process can draw the same number again. The n-th draw is word n of Philox4x32-10 (Salmon et al.,
/// SC 2011) keyed by them. Mappings to reals, integers and shuffles are our own, as those of the
/// standard library differ between implementations.
class Random {
 public:
  Random(std::uint64_t seed, Stream stream, std::uint64_t entity = 0, std::uint32_t index = 0);

  std::uint32_t NextWord();
  /// Uniform in [0, 1) with 53 random bits.
  double Uniform();
  /// Uniform in [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Uniform in [0, n), n > 0, without bias (Lemire 2019).
  std::uint32_t Below(std::uint32_t n);

  /// Fisher-Yates.
  template <class T>
  void Shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) {
      std::swap(items[i - 1], items[Below(static_cast<std::uint32_t>(i))]);
    }
  }

 private:
  std::uint32_t key_[2];
  std::uint32_t counter_[4];
  std::uint32_t block_[4];
  int next_ = 4;
};

}  // namespace muster

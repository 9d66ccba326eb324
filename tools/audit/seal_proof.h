#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/seal.h"

namespace muster::tools::audit {

/// Proves that a log's messages come from members of the mission: each message on a channel of ours
/// must have the tag that the key of its run makes.
class SealProof {
 public:
  /// `key`: a run's, or one of many runs; `from`: where it is from, for messages.
  SealProof(const SealKey& key, std::string from) : key_(key), from_(std::move(from)) {}
  /// Of one run.
  SealProof(Seal seal, std::string from) : from_(std::move(from)), seal_(std::move(seal)) {}

  /// Whether the event is proven, or nothing that wants a proof.
  bool Takes(const LogEvent& event, const std::string& file);

  std::int64_t proven() const { return proven_; }
  std::int64_t refused() const { return refused_; }
  /// The first refused one, by file and number, in words; "": there is none.
  const std::string& first_refused() const { return first_refused_; }
  std::int64_t first_refused_us() const { return first_refused_us_; }  ///< its mission time

 private:
  std::optional<SealKey> key_;
  std::string from_;
  std::optional<Seal> seal_;  ///< of the run that was last seen
  std::optional<std::int64_t> run_id_;
  std::int64_t proven_ = 0, refused_ = 0, first_refused_us_ = 0;
  std::string first_refused_;
};

}  // namespace muster::tools::audit

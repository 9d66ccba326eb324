#pragma once

#include <memory>
#include <utility>
#include <variant>

#include "protocol/process.h"
#include "recorder/archive.h"

namespace muster::tools::testing {

/// The recorder as far as it tells those that start again what it has heard, and says again, for
/// the log, the last clock of a world that has died.
class Archivist : public Process {
 public:
  Archivist(const Scenario& scenario, bool goes_on)
      : Process({1, "recorder", 0}, 0), archive_(scenario, 1, goes_on) {}

 private:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) override {
    archive_.Add(packet);
    if (packet.channel == "MUSTER_CLOCK") clock_ = std::make_shared<const Packet>(packet);
    const auto* const request = std::get_if<request_t>(&message);
    if (request == nullptr) return;
    if (request->header.sender == "world" && clock_) sender().Resend(std::exchange(clock_, {}));
    for (answer_t& answer : archive_.Answer(*request, now.monotonic_us)) {
      sender().Send("MUSTER_ANSWER", std::move(answer), 0, now);
    }
  }
  void OnStep(const Now&) override {}
  TimeUs OwnWakeUs() const override { return kNever; }
  std::int64_t tick() const override { return 0; }

  recorder::Archive archive_;
  SentPacket clock_;
};

}  // namespace muster::tools::testing

#include "lcmtypes/bus/memory_bus.h"

#include <utility>

#include "lcmtypes/bus/limits.h"

namespace muster {

class MemoryHub::Member : public Bus {
 public:
  explicit Member(MemoryHub* hub) : hub_(hub) { hub_->members_.push_back(this); }
  ~Member() override { std::erase(hub_->members_, this); }
  Member(const Member&) = delete;
  Member& operator=(const Member&) = delete;

  void Publish(const Packet& packet) override {
    RequireAcceptable(packet);
    hub_->Send(packet);
  }

  /// Never waits: with one thread nothing can arrive meanwhile.
  std::vector<Packet> Receive(std::int64_t /*timeout_us*/) override {
    return std::exchange(queue_, {});
  }

  void Enqueue(const Packet& packet) { queue_.push_back(packet); }

 private:
  MemoryHub* hub_;
  std::vector<Packet> queue_;
};

std::unique_ptr<Bus> MemoryHub::Join() { return std::make_unique<Member>(this); }

void MemoryHub::Send(const Packet& packet) {
  for (Member* member : members_) member->Enqueue(packet);
}

}  // namespace muster

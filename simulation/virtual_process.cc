#include "simulation/virtual_process.h"

#include <algorithm>
#include <utility>

#include "base/check.h"

namespace muster::simulation {
namespace {

/// Takes the socket over.
std::unique_ptr<LossyBus> OpenBus(Bus* socket, std::uint64_t seed, const std::string& name,
                                  const PacketFaults& faults, const VirtualNetwork& network) {
  auto bus = std::make_unique<LossyBus>(std::unique_ptr<Bus>(socket), seed, name,
                                        [&network] { return network.now_us(); });
  bus->SetFaults(faults);
  return bus;
}

}  // namespace

VirtualProcess::VirtualProcess(VirtualNetwork* network, std::unique_ptr<Process> core,
                               std::uint64_t seed, const PacketFaults& faults,
                               std::function<TimeUs()> wall_us)
    : network_(network),
      wall_us_(std::move(wall_us)),
      core_(std::move(core)),
      socket_(new VirtualSocket(network, this)),
      bus_(OpenBus(socket_, seed, name(), faults, *network)),
      drive_(core_.get(), bus_.get()),
      turn_us_(network->now_us()) {
  network_->Join(this);
}

VirtualProcess::~VirtualProcess() { network_->Leave(this); }

TimeUs VirtualProcess::wake_us() const {
  if (stopped_ || !failure_.empty()) return kNever;
  if (!socket_->empty()) return network_->now_us();
  return std::min(turn_us_, bus_->due_us());
}

void VirtualProcess::Wake() {
  const TimeUs now_us = network_->now_us();
  const std::vector<Packet> arrived = bus_->Receive(0);
  // What arrived may be on its way still: nothing to turn for.
  if (arrived.empty() && now_us < turn_us_) return;
  // No host, no CPU time: nothing in a log that its seed does not tell.
  try {
    drive_.Turn(arrived, {now_us, wall_us_ ? wall_us_() : now_us}, [] { return Usage(); });
  } catch (const InputError& error) {
    failure_ = error.what();
  }
  // A turn takes some time, without which one that wants the next at once would hold time still.
  turn_us_ = std::max(drive_.wake_us(now_us), now_us + 1);
}

}  // namespace muster::simulation

#include "simulation/virtual_logger.h"

#include <utility>

namespace muster::simulation {
namespace {

constexpr TimeUs kFlushUs = 1'000;

}  // namespace

VirtualLogger::VirtualLogger(VirtualNetwork* network, std::vector<Event>* file)
    : network_(network), file_(file), socket_(network, this), flushed_us_(network->now_us()) {
  network_->Join(this);
}

VirtualLogger::~VirtualLogger() { network_->Leave(this); }

void VirtualLogger::set_stopped(bool stopped) {
  stopped_ = stopped;
  if (stopped) return;
  for (Packet& packet : socket_.Receive(0)) {
    Log(std::make_shared<const Packet>(std::move(packet)));
  }
}

void VirtualLogger::OnArrival(const SentPacket& packet) {
  stopped_ ? socket_.Enqueue(packet) : Log(packet);
}

void VirtualLogger::Log(const SentPacket& packet) {
  if (died_) return;
  held_.push_back({network_->now_us(), packet});
  if (network_->now_us() >= flushed_us_ + kFlushUs) Flush();
}

void VirtualLogger::Flush() {
  flushed_us_ = network_->now_us();
  if (held_.empty() || died_) return;
  if (disk_full_) {
    died_ = true;
    return;
  }
  file_->insert(file_->end(), std::make_move_iterator(held_.begin()),
                std::make_move_iterator(held_.end()));
  held_.clear();
}

}  // namespace muster::simulation

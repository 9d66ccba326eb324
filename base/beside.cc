#include "base/beside.h"

#include <chrono>
#include <utility>

namespace muster {

Beside::~Beside() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Beside::Start(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    job_ = std::packaged_task<void()>(std::move(job));
    end_ = job_.get_future();
  }
  if (thread_.joinable()) {
    wake_.notify_one();
  } else {
    thread_ = std::thread([this] { Run(); });
  }
}

bool Beside::EndsWithin(TimeUs us) {
  if (end_.wait_for(std::chrono::microseconds(us)) != std::future_status::ready) return false;
  end_.get();
  return true;
}

void Beside::Run() {
  while (true) {
    std::packaged_task<void()> job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopped_ || job_.valid(); });
      if (!job_.valid()) return;
      job = std::exchange(job_, {});
    }
    job();
  }
}

}  // namespace muster

#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

#include "base/units.h"

namespace muster {

/// A thread that runs one long job at a time, while its owner does something else.
class Beside {
 public:
  Beside() = default;
  /// Waits for the job.
  ~Beside();
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  /// The job before must have ended.
  void Start(std::function<void()> job);
  /// Whether the job ends within that time. Rethrows what it threw.
  bool EndsWithin(TimeUs us);
  /// Waits for its end. Rethrows what it threw.
  void Wait() { end_.get(); }

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::packaged_task<void()> job_;  ///< the next; none: not valid
  bool stopped_ = false;
  std::future<void> end_;
  std::thread thread_;  ///< from the first job on; caches of a thread then last from job to job
};

}  // namespace muster

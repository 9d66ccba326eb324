#include "scheduler/solver/parallel.h"

#include <exception>

#include "base/beside.h"

namespace muster::scheduler {

void AtOnce(const std::function<void()>& own, const std::function<void()>& other) {
  // To start a thread, and to fill its caches, takes longer than much of what is done in it.
  thread_local Beside second;
  thread_local bool is_busy = false;
  if (is_busy) {
    own();
    other();
    return;
  }
  is_busy = true;
  second.Start(other);
  std::exception_ptr thrown;
  try {
    own();
  } catch (...) {
    thrown = std::current_exception();
  }
  is_busy = false;
  second.Wait();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace muster::scheduler

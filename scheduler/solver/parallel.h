#pragma once

#include <cstddef>
#include <functional>

namespace muster::scheduler {

/// Calls both at once: `other` on a second thread, which stays for the next call of the calling
/// thread. A call within a call is made one after the other. Throws what they throw.
void AtOnce(const std::function<void()>& own, const std::function<void()>& other);

/// Calls body(begin, end) over [0, n), in two halves at once when `threads` is 2 and n is at least
/// `worth`. The body writes to places of its own indices only, so the result is that of one call.
template <class Body>
void ParallelFor(std::size_t n, int threads, std::size_t worth, Body&& body) {
  if (threads < 2 || n < worth) {
    body(std::size_t{0}, n);
    return;
  }
  AtOnce([&] { body(std::size_t{0}, n / 2); }, [&] { body(n / 2, n); });
}

}  // namespace muster::scheduler

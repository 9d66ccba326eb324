#pragma once

#include <cstddef>
#include <thread>

namespace muster::scheduler {

/// Calls body(begin, end) over [0, n), in two halves at once when `threads` is 2 and n is at least
/// `worth`. The body writes to places of its own indices only, so the result is that of one call.
template <class Body>
void ParallelFor(std::size_t n, int threads, std::size_t worth, Body&& body) {
  if (threads < 2 || n < worth) {
    body(std::size_t{0}, n);
    return;
  }
  std::jthread other([&] { body(n / 2, n); });
  body(std::size_t{0}, n / 2);
}

}  // namespace muster::scheduler

#include "scheduler/solver/parallel.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace muster::scheduler {
namespace {

TEST(Parallel, EachIndexIsDoneOnceInTwoThreadsThatStay) {
  std::set<std::thread::id> others;
  for (int call = 0; call < 3; ++call) {
    std::vector<int> done(101);
    std::vector<std::thread::id> by(done.size());
    ParallelFor(done.size(), 2, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        ++done[i];
        by[i] = std::this_thread::get_id();
      }
    });
    EXPECT_EQ(done, std::vector<int>(101, 1));
    EXPECT_EQ(by.front(), std::this_thread::get_id());
    others.insert(by.back());
  }
  EXPECT_EQ(others.size(), 1u);
  EXPECT_EQ(others.count(std::this_thread::get_id()), 0u);
}

TEST(Parallel, WhatIsTooLittleOrForOneThreadStaysInIt) {
  for (const auto& [n, threads] : {std::pair(std::size_t{9}, 2), std::pair(std::size_t{10}, 1)}) {
    int calls = 0;
    ParallelFor(n, threads, 10, [&, n = n](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin, 0u);
      EXPECT_EQ(end, n);
      ++calls;
    });
    EXPECT_EQ(calls, 1);
  }
}

TEST(Parallel, ACallWithinACallIsMadeInItsThread) {
  std::vector<int> done(64);
  ParallelFor(8, 2, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ParallelFor(8, 2, 1, [&, i](std::size_t from, std::size_t to) {
        for (std::size_t j = from; j < to; ++j) ++done[8 * i + j];
      });
    }
  });
  EXPECT_EQ(done, std::vector<int>(64, 1));
}

TEST(Parallel, WhatIsThrownIsThrownOnceBothHaveEnded) {
  for (const bool by_other : {false, true}) {
    int ended = 0;
    const auto fails = [] { throw std::runtime_error("no"); };
    const auto ends = [&] { ++ended; };
    EXPECT_THROW(by_other ? AtOnce(ends, fails) : AtOnce(fails, ends), std::runtime_error);
    EXPECT_EQ(ended, 1);
    AtOnce(ends, [] {});
    EXPECT_EQ(ended, 2) << "and it goes on";
  }
}

}  // namespace
}  // namespace muster::scheduler

#include "base/beside.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace muster {
namespace {

TEST(Beside, RunsOneJobAfterTheOtherOnOneThread) {
  Beside beside;
  std::thread::id first, second;
  beside.Start([&] { first = std::this_thread::get_id(); });
  ASSERT_TRUE(beside.EndsWithin(60 * kSecondUs));
  beside.Start([&] { second = std::this_thread::get_id(); });
  ASSERT_TRUE(beside.EndsWithin(60 * kSecondUs));
  EXPECT_EQ(first, second) << "its caches would be lost";
  EXPECT_NE(first, std::this_thread::get_id());
}

TEST(Beside, SaysWhetherTheJobHasEnded) {
  Beside beside;
  std::atomic<bool> may_end = false;
  beside.Start([&] {
    while (!may_end) std::this_thread::yield();
  });
  EXPECT_FALSE(beside.EndsWithin(0));
  EXPECT_FALSE(beside.EndsWithin(1000));
  may_end = true;
  EXPECT_TRUE(beside.EndsWithin(60 * kSecondUs));
}

TEST(Beside, RethrowsAndGoesOn) {
  Beside beside;
  beside.Start([] { throw std::runtime_error("no"); });
  EXPECT_THROW(beside.EndsWithin(60 * kSecondUs), std::runtime_error);
  bool done = false;
  beside.Start([&] { done = true; });
  ASSERT_TRUE(beside.EndsWithin(60 * kSecondUs));
  EXPECT_TRUE(done);
}

TEST(Beside, WaitsForItsJobWhenItGoes) {
  bool done = false;
  {
    Beside beside;
    beside.Start([&] { done = true; });
  }
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace muster

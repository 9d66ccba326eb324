#include "tools/files/log_progress.h"

#include <gtest/gtest.h>

namespace muster::tools {
namespace {

TEST(LogProgress, SaysHowMuchIsRead) {
  EXPECT_EQ(LogProgress::Line("audit", 430'000'000, 1'000'000'000), "audit: 43 % of 1.0 GB read");
  EXPECT_EQ(LogProgress::Line("info", 0, 26'400'000), "info: 0 % of 26.4 MB read");
  // Tags, or a log that grew since.
  EXPECT_EQ(LogProgress::Line("info", 11, 10), "info: 100 % of 0.0 MB read");
  EXPECT_EQ(LogProgress::Line("info", 0, 0), "info: 100 % of 0.0 MB read");
}

TEST(LogProgress, IsSilentAtFirst) {
  LogProgress progress("audit", {"/nowhere/mission.lcm"});
  LogEvent event;
  event.packet.bytes.resize(3 << 20);
  ::testing::internal::CaptureStderr();
  progress.Add(event);
  progress.Rewind();
  progress.Add(event);
  progress.Break();
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace muster::tools

#include "tools/host/child.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <thread>

#include "base/check.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

class ChildTest : public ::testing::Test {
 protected:
  ChildSpec Shell(const std::string& script) const {
    return {"child", {"/bin/sh", "-c", script}, output_};
  }
  static bool Ended(Child* child) {
    return Eventually([child] { return child->Poll().has_value(); });
  }
  TemporaryFolder folder_;
  std::string output_ = folder_.File("child.stderr");
};

TEST_F(ChildTest, SaysHowItEndedAndWhatItSaid) {
  Child child(Shell("echo one; echo two >&2; exit 3"));
  ASSERT_TRUE(Ended(&child));
  EXPECT_EQ(child.Poll()->Text(), "exited with code 3");
  EXPECT_FALSE(child.Poll()->clean());
  EXPECT_EQ(TextOf(output_), "one\ntwo\n");
}

TEST_F(ChildTest, SaysWhichSignalKilledIt) {
  Child child(Shell("while :; do sleep 1; done"));
  EXPECT_FALSE(child.Poll());
  child.Signal(SIGKILL);
  ASSERT_TRUE(Ended(&child));
  EXPECT_EQ(child.Poll()->Text(), "was killed by signal 9 (Killed)");
}

TEST_F(ChildTest, OneAskedToEndBeforeItCanCatchThatEndsCleanly) {
  Child asked(Shell("while :; do sleep 0.01; done"));
  asked.AskToEnd();
  ASSERT_TRUE(Ended(&asked));
  EXPECT_TRUE(asked.Poll()->clean()) << asked.Poll()->Text();
  Child killed(Shell("while :; do sleep 0.01; done"));
  killed.Signal(SIGTERM);
  ASSERT_TRUE(Ended(&killed));
  EXPECT_FALSE(killed.Poll()->clean());
}

TEST_F(ChildTest, OneWhoseDiskWaitsAreSkippedIsToldThatAllIsOnDisk) {
  // A device that cannot: it says so, unless nobody asks it.
  ChildSpec spec = Shell("sync --data /dev/null");
  Child waits(spec);
  ASSERT_TRUE(Ended(&waits));
  EXPECT_FALSE(waits.Poll()->clean());
  spec.disk_waits = DiskWaits::kSkipped;
  Child skips(spec);
  ASSERT_TRUE(Ended(&skips));
  EXPECT_TRUE(skips.Poll()->clean()) << TextOf(output_);
}

TEST_F(ChildTest, AProgramThatIsNotThereIsAnErrorThatNamesIt) {
  try {
    Child child({"child", {"/nowhere/muster-uav"}, output_});
    FAIL();
  } catch (const SystemError& error) {
    EXPECT_STREQ(error.what(), "cannot start /nowhere/muster-uav: No such file or directory");
  }
}

TEST_F(ChildTest, AStoppedOneThatIsAskedToEndEnds) {
  Child child(Shell("trap 'exit 7' TERM; echo ready; while :; do sleep 0.01; done"));
  ASSERT_TRUE(Eventually([&] { return TextOf(output_) == "ready\n"; }));
  child.Signal(SIGSTOP);
  ASSERT_TRUE(Eventually([&] { return child.Stopped(); }));
  child.AskToEnd();
  ASSERT_TRUE(Ended(&child));
  EXPECT_EQ(child.Poll()->Text(), "exited with code 7");
}

// Else the check for leaks at a process's exit may hang: it attaches to its threads, and a SIGCONT
// takes back the stop that it waits for.
TEST_F(ChildTest, NothingContinuesItAfterItWasAskedToEnd) {
  // On one processor, before a thread that has time for everybody, a child mostly acts on a signal
  // at once.
  cpu_set_t processors;
  ASSERT_EQ(sched_getaffinity(0, sizeof processors, &processors), 0);
  int first = 0;
  while (!CPU_ISSET(first, &processors)) ++first;
  CPU_ZERO(&processors);
  CPU_SET(first, &processors);
  for (int i = 0; i < 8; ++i) {
    Child child({"child", {MUSTER_SIGNAL_TAKER}, output_});
    const auto says = [this](const char* words) {
      return Eventually([&] { return TextOf(output_) == words; });
    };
    ASSERT_TRUE(says("ready\n")) << TextOf(output_);
    ASSERT_EQ(sched_setaffinity(child.pid(), sizeof processors, &processors), 0);
    std::thread([&] {
      const sched_param lowest = {};
      EXPECT_EQ(sched_setaffinity(0, sizeof processors, &processors), 0);
      EXPECT_EQ(sched_setscheduler(0, SCHED_IDLE, &lowest), 0);
      child.AskToEnd();
    }).join();
    ASSERT_TRUE(says("ready\ntold to end\n")) << TextOf(output_);
    child.Signal(SIGUSR1);
    ASSERT_TRUE(Ended(&child));
    ASSERT_TRUE(child.Poll()->clean()) << child.Poll()->Text();
  }
}

TEST_F(ChildTest, ItsDestructorLeavesNothing) {
  pid_t pid = 0;
  {
    Child child(Shell("trap '' TERM INT; echo ready; while :; do sleep 1; done"));
    pid = child.pid();
    ASSERT_TRUE(Eventually([&] { return TextOf(output_) == "ready\n"; }));
  }
  EXPECT_EQ(kill(pid, 0), -1);
}

TEST_F(ChildTest, HasNoInputNoOtherFilesAndAGroupOfItsOwn) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);  // not close-on-exec
  Child child(Shell("cat; exec ls /proc/self/fd"));
  const pid_t group = getpgid(child.pid());
  ASSERT_TRUE(Ended(&child));
  close(ends[0]);
  close(ends[1]);
  EXPECT_TRUE(group == child.pid() || group == -1) << group;
  EXPECT_EQ(TextOf(output_), "0\n1\n2\n3\n");  // 3 is the folder that ls reads
}

TEST_F(ChildTest, DiesWithAParentThatIsKilled) {
  // The orphan becomes ours, so that its end can be seen exactly.
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t parent = fork();
  if (parent == 0) {
    Child child(Shell("trap '' TERM INT HUP; echo ready; while :; do sleep 1; done"));
    const pid_t pid = child.pid();
    if (!Eventually([&] { return TextOf(output_) == "ready\n"; })) _exit(1);
    if (write(ends[1], &pid, sizeof pid) != sizeof pid) _exit(1);
    kill(getpid(), SIGKILL);
    _exit(1);
  }
  ASSERT_GT(parent, 0);
  close(ends[1]);
  pid_t orphan = 0;
  ASSERT_EQ(read(ends[0], &orphan, sizeof orphan), static_cast<ssize_t>(sizeof orphan));
  close(ends[0]);
  int status = 0;
  ASSERT_EQ(waitpid(parent, &status, 0), parent);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_TRUE(Eventually([&] { return waitpid(orphan, &status, WNOHANG) == orphan; }));
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  EXPECT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 0), 0);
}

TEST_F(ChildTest, LastLinesOfAFile) {
  std::ofstream(output_) << "1\n2\n3\n4";
  EXPECT_EQ(LastLines(output_, 2), "3\n4");
  EXPECT_EQ(LastLines(output_, 4), "1\n2\n3\n4");
  EXPECT_EQ(LastLines(output_, 9), "1\n2\n3\n4");
  std::ofstream(output_) << "\n\n";
  EXPECT_EQ(LastLines(output_, 2), "");
  std::ofstream(output_) << std::string(10'000, 'x') << "\nlast\n\n";
  EXPECT_EQ(LastLines(output_, 1), "last");
  EXPECT_EQ(LastLines(folder_.File("none"), 2), "");
}

}  // namespace
}  // namespace muster::tools

// muster-scheduler, but for two policies: "certified" leaves an action out of each decision, and
// "mpq" takes 1.7 s for each.
#include "scheduler/process/scheduler_main.h"
#include "tests/scheduler/odd_policies.h"

int main(int argc, char** argv) {
  using namespace muster::scheduler;
  return SchedulerMain(
      argc, argv,
      {{"certified",
        [] { return std::make_unique<testing::LyingPolicy>("certified", testing::Lie::kOneLess); }},
       {"mpq", [] {
          return std::make_unique<testing::SlowPolicy>("mpq", std::chrono::milliseconds(1700));
        }}});
}

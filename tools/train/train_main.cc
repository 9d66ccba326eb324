// muster-train: what `muster train` starts.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "base/program.h"
#include "base/say.h"
#include "tools/host/stop_signals.h"
#include "tools/train/train_options.h"

namespace muster::tools {
namespace {

std::string Clock(double seconds) {
  const int whole = static_cast<int>(std::max(0.0, seconds));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

/// One line, in place on a terminal; else one a look at the held-out missions.
class ProgressLine {
 public:
  explicit ProgressLine(const learning::TrainSettings& settings)
      : settings_(settings), in_place_(isatty(STDERR_FILENO) != 0) {}

  void Show(const learning::TrainProgress& now) {
    if (!in_place_ && !now.looked) return;
    if (in_place_ && !now.looked && now.seconds - shown_s_ < 0.5) return;
    shown_s_ = now.seconds;
    const std::string line = fmt::format(
        "{} of {}  missions {}  return {:.1f}  loss {:.3g}  held-out {:.1f} %  best {:.1f} %  left "
        "{}",
        Clock(now.seconds), Clock(settings_.seconds), now.episodes, now.episode_return, now.loss,
        100 * now.completion, 100 * now.best, Clock(settings_.seconds - now.seconds));
    SayTo(stderr, in_place_ ? "\r" + line + "\033[K" : line + "\n");
  }
  ~ProgressLine() {
    if (in_place_) SayTo(stderr, "\n");
  }

 private:
  const learning::TrainSettings& settings_;
  bool in_place_;
  double shown_s_ = -1;
};

int Run(int argc, const char* const* argv) {
  const auto options = ParseTrainOptions(argc, argv);
  if (!options) return kExitOk;
  learning::SetUpLibtorch();
  if (options->random) {
    fmt::print("random choices  {:.1f} % of the tasks of {} held-out missions\n",
               100 * learning::RandomCompletion(options->settings), options->settings.held_out);
    return kExitOk;
  }
  const double speed = learning::BlasSpeed();
  if (speed < 20) {
    Say("warning: matrices are multiplied at {:.0f} GFLOP/s, training is slow: is "
        "libopenblas0-pthread installed, and is the processor free?\n",
        speed);
  }
  const StopSignals stop;
  learning::TrainResult result;
  {
    ProgressLine line(options->settings);
    result = learning::Train(
        options->settings,
        [&](const learning::TrainProgress& now) {
          if (!options->quiet) line.Show(now);
        },
        [&] { return stop.count() > 0; });
  }
  fmt::print(
      "method          {}\nmissions        {}{}\ntime            {}\nheld-out        best {:.1f} "
      "%, "
      "last {:.1f} %\nmodel           {}\n",
      options->settings.method, result.end.episodes,
      result.resumed ? ", went on from a checkpoint" : "", Clock(result.end.seconds),
      100 * result.end.best, 100 * result.end.completion, options->settings.folder);
  return result.interrupted ? kExitInterrupted : kExitOk;
}

}  // namespace
}  // namespace muster::tools

int main(int argc, char** argv) {
  return muster::GuardedMain("muster", [&] { return muster::tools::Run(argc, argv); });
}

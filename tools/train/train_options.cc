#include "tools/train/train_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/check.h"
#include "base/options.h"
#include "base/text.h"
#include "learning/practice_mission.h"
#include "scheduler/policies/learned/model.h"
#include "tools/scenario/settings_options.h"

namespace muster::tools {
namespace {

using scheduler::learned::kMethodNames;

/// Episodes until exploring is down to its least. QTRAN's two losses need longer.
constexpr std::int64_t kAnneal = 500, kAnnealOfQtran = 1200;

constexpr std::string_view kNodeValue = "node-value";

std::string MethodIn(const Arguments& arguments) {
  std::string method = arguments.Get("policy");
  if (method == "marl") return "qmix";
  if (method == kNodeValue) return method;
  if (std::find(kMethodNames.begin(), kMethodNames.end(), method) != kMethodNames.end()) {
    return method;
  }
  throw InputError("command line", "--policy", method,
                   fmt::format("one of {}, {}{}", fmt::join(kMethodNames, ", "), kNodeValue,
                               DidYouMean(method, kMethodNames)));
}

}  // namespace

std::optional<TrainOptions> ParseTrainOptions(int argc, const char* const* argv) {
  Options options(
      "muster train",
      "Trains a learned policy of the paper's appendix B on missions in this process; "
      "use it with --policy learned:MODEL (docs/guide/learned.md). Ctrl-C keeps the best "
      "model so far, the same command goes on.");
  options
      .Add("policy", "NAME",
           fmt::format("What to train: {}; {}: the coefficients of horizon-learned, without "
                       "libtorch",
                       fmt::join(kMethodNames, " "), kNodeValue))
      .Default("qmix");
  options.Add("preset", "NAME", "Missions to train on: each is drawn anew (muster scenario --list)")
      .Default("Random_1");
  options
      .Add("minutes", "MIN", "Minutes to train, of the processor; those before a resumption count")
      .Number(Above0(1e5))
      .Default(20);
  options.Add("episodes", "N", "End after so many missions, too; node-value: generations")
      .Integer(1);
  options.Add("seed", "N", "Seed of all random draws").Seed().Default(1);
  options.Out("DIR",
              "Folder of the model, its checkpoint and its learning curve (default: "
              "models/PRESET-NAME)");
  options.Flag("fresh", "Begin anew, whatever the folder holds");
  options.Flag("random", "Only tell what random choices get done on the held-out missions");
  options.Quiet();
  AddNumberOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return std::nullopt;
  TrainOptions train;
  learning::TrainSettings& settings = train.settings;
  settings.method = MethodIn(*arguments);
  settings.scenario = SettingsFrom(*arguments, PresetByName(arguments->Get("preset")));
  settings.seed = arguments->Get<std::uint64_t>("seed");
  settings.seconds = arguments->Get<double>("minutes") * 60;
  arguments->Read("episodes", &settings.episodes);
  settings.anneal = settings.method == "qtran" ? kAnnealOfQtran : kAnneal;
  settings.folder = arguments->Has("out")
                        ? arguments->Get("out")
                        : fmt::format("models/{}-{}", settings.scenario.name, settings.method);
  settings.resume = !arguments->Has("fresh");
  train.node_value = settings.method == kNodeValue;
  train.random = arguments->Has("random");
  train.quiet = arguments->Has("quiet");
  // A scenario that cannot be trained on is an error before anything starts.
  [[maybe_unused]] const learning::PracticeMission probe(Generate(settings.scenario, 1));
  return train;
}

}  // namespace muster::tools

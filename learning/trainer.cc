#include "learning/trainer.h"

#include <fmt/format.h>
#include <malloc.h>
#include <torch/serialize.h>
#include <torch/utils.h>
#include <torch/version.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <deque>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "base/check.h"
#include "base/index.h"
#include "base/random.h"
#include "learning/episode.h"
#include "learning/learner.h"
#include "learning/replay.h"
#include "scheduler/policies/learned/model.h"

namespace muster::learning {
namespace {

using scheduler::learned::kFeatureVersion;
using scheduler::learned::Model;
using scheduler::learned::Network;
using scheduler::learned::Shape;
using scheduler::learned::ShapeOf;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// Time of this process on its processor: a busy machine does not make a model worse.
double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

/// Missions that are trained on, and held-out ones: seeds that nobody types.
constexpr std::uint64_t kFirstHeldOut = 900'000'000;
constexpr std::uint64_t kFirstEpisode = 1'000'000'000;
constexpr std::size_t kRecent = 50;

/// What the random numbers of one episode are for.
enum Draws : std::uint64_t { kExploring = 0, kReplaying = 1 };

Random DrawsOf(std::uint64_t seed, Draws what, std::int64_t episode) {
  return Random(seed, Stream::kTraining, static_cast<std::uint64_t>(episode),
                static_cast<std::uint32_t>(what));
}

double HeldOut(const TrainSettings& settings, const Shape& shape, const Network* network,
               double share) {
  double sum = 0;
  for (int i = 0; i < settings.held_out; ++i) {
    const auto seed = kFirstHeldOut + static_cast<std::uint64_t>(i);
    sum += PlayEpisode(Generate(settings.scenario, seed), shape, network, share,
                       DrawsOf(seed, kExploring, 0), false)
               .completion;
  }
  return sum / settings.held_out;
}

double MeanOf(const std::deque<double>& values) {
  return values.empty() ? 0
                        : std::accumulate(values.begin(), values.end(), 0.0) /
                              static_cast<double>(values.size());
}

class Training {
 public:
  Training(const TrainSettings& settings)
      : settings_(settings),
        shape_(ShapeOf(Generate(settings.scenario, kFirstHeldOut))),
        learner_(SettingsOf(settings), MissionProblem(shape_)) {
    fs::create_directories(settings.folder);
  }

  TrainResult Run(const std::function<void(const TrainProgress&)>& say,
                  const std::function<bool()>& stop) {
    result_.resumed = settings_.resume && Resume();
    const double before_s = now_.seconds;
    const double start_s = ProcessorSeconds();
    auto saved = Clock::now();
    now_.looked = has_best_;  // nothing new to look at, as long as no mission is played
    while (!Ended()) {
      if (stop()) {
        result_.interrupted = true;
        break;
      }
      RunEpisode();
      const auto at = Clock::now();
      now_.seconds = before_s + ProcessorSeconds() - start_s;
      now_.looked = now_.episodes % settings_.look_every == 0;
      if (now_.looked) Look();
      say(now_);
      if (std::chrono::duration<double>(at - saved).count() >= settings_.checkpoint_s) {
        saved = at;
        Save();
      }
    }
    if (!now_.looked) {
      now_.looked = true;
      Look();
      say(now_);
    }
    Save();
    result_.end = now_;
    result_.hash = learner_.Hash();
    return result_;
  }

 private:
  static LearnerSettings SettingsOf(const TrainSettings& settings) {
    LearnerSettings learner;
    learner.method.method = MethodOf(settings.method);
    learner.seed = settings.seed;
    return learner;
  }
  std::string File(const std::string& name) const { return settings_.folder + "/" + name; }
  bool Ended() const {
    return now_.seconds >= settings_.seconds ||
           (settings_.episodes > 0 && now_.episodes >= settings_.episodes);
  }
  bool mean_field() const { return settings_.method == "mf-qmix"; }
  Network Acting() const {
    return Network(learner_.ActingTensors(), shape_, mean_field(), "training");
  }

  void RunEpisode() {
    const std::int64_t n = now_.episodes++;
    const double share =
        std::max(settings_.least_random,
                 settings_.most_random -
                     (settings_.most_random - settings_.least_random) * static_cast<double>(n) /
                         static_cast<double>(std::max<std::int64_t>(settings_.anneal, 1)));
    const Network network = Acting();
    Episode episode = PlayEpisode(
        Generate(settings_.scenario, kFirstEpisode + settings_.seed * 1'000'000 + muster::At(n)),
        shape_, &network, share, DrawsOf(settings_.seed, kExploring, n), true);
    Note(&returns_, ReturnOf(episode));
    now_.episode_return = MeanOf(returns_);
    if (replay_.size() < muster::At(settings_.replay)) {
      replay_.push_back(std::move(episode));
    } else {
      replay_[muster::At(n) % replay_.size()] = std::move(episode);
    }
    if (replay_.size() < muster::At(settings_.batch)) return;
    Random random = DrawsOf(settings_.seed, kReplaying, n);
    std::vector<const Episode*> batch;
    for (int i = 0; i < settings_.batch; ++i) {
      batch.push_back(&replay_[random.Below(static_cast<std::uint32_t>(replay_.size()))]);
    }
    const Lesson lesson = LessonOf(batch, shape_);
    Note(&losses_, learner_.Update(lesson.seen, lesson.happened));
    now_.loss = MeanOf(losses_);
    if (now_.episodes % settings_.target_every == 0) learner_.CopyToTarget();
  }

  static double ReturnOf(const Episode& episode) {
    double sum = 0;
    for (const Turn& turn : episode.turns) sum += turn.reward;
    return sum;
  }
  static void Note(std::deque<double>* recent, double value) {
    recent->push_back(value);
    if (recent->size() > kRecent) recent->pop_front();
  }

  /// At the held-out missions; keeps the best model.
  void Look() {
    const Network network = Acting();
    now_.completion = HeldOut(settings_, shape_, &network, 0);
    curve_.push_back(fmt::format("{:.1f},{},{:.3f},{:.5g},{:.4f}", now_.seconds, now_.episodes,
                                 now_.episode_return, now_.loss, now_.completion));
    if (!has_best_ || now_.completion > now_.best) {
      has_best_ = true;
      now_.best = now_.completion;
      Model model;
      model.method = settings_.method == "marl" ? "qmix" : settings_.method;
      model.shape = shape_;
      model.tensors = learner_.ActingTensors();
      model.preset = settings_.scenario.name;
      model.seed = settings_.seed;
      model.episodes = now_.episodes;
      model.train_s = now_.seconds;
      model.held_out = now_.completion;
      model.trained_by = "libtorch " TORCH_VERSION;
      WriteModel(model, settings_.folder);
    }
    WriteCurve();
  }

  void WriteCurve() const {
    std::ofstream csv(File("curve.csv"));
    csv << "seconds,episodes,return,loss,held_out_completion\n";
    for (const std::string& row : curve_) csv << row << "\n";
    std::ofstream plot(File("curve.gp"));
    plot << fmt::format(
        "# gnuplot -p curve.gp\n"
        "set datafile separator ','\nset key bottom right\nset title '{} on {}, seed {}'\n"
        "set xlabel 'minutes'\nset ylabel 'held-out completion'\nset y2label 'loss'\n"
        "set ytics nomirror\nset y2tics\nset yrange [0:1]\n"
        "plot 'curve.csv' using ($1/60):5 skip 1 with lines title 'completion', \\\n"
        "     '' using ($1/60):4 skip 1 axes x1y2 with lines title 'loss'\n",
        settings_.method, settings_.scenario.name, settings_.seed);
    if (!csv || !plot) throw SystemError(File("curve.csv") + ": cannot be written");
  }

  /// What a checkpoint must agree on.
  Json Key() const {
    return {{"method", settings_.method},  {"scenario", settings_.scenario.name},
            {"shape", ToString(shape_)},   {"seed", settings_.seed},
            {"features", kFeatureVersion}, {"tasks", settings_.scenario.tasks}};
  }

  void Save() const {
    torch::serialize::OutputArchive archive;
    learner_.Save(&archive);
    const Json meta = {{"key", Key()},
                       {"episodes", now_.episodes},
                       {"seconds", now_.seconds},
                       {"completion", now_.completion},
                       {"best", now_.best},
                       {"curve", curve_}};
    archive.write("meta", c10::IValue(meta.dump()));
    const std::string next = File("checkpoint.pt.next");
    archive.save_to(next);
    fs::rename(next, File("checkpoint.pt"));
  }

  bool Resume() {
    if (!fs::exists(File("checkpoint.pt"))) return false;
    try {
      torch::serialize::InputArchive archive;
      archive.load_from(File("checkpoint.pt"));
      c10::IValue text;
      archive.read("meta", text);
      const Json meta = Json::parse(text.toStringRef());
      if (meta.at("key") != Key()) {
        throw InputError(File("checkpoint.pt"), "training", meta.at("key").dump(),
                         Key().dump() + ": another folder, or --fresh");
      }
      learner_.Load(&archive);
      now_.episodes = meta.at("episodes");
      now_.seconds = meta.at("seconds");
      now_.completion = meta.at("completion");
      now_.best = meta.at("best");
      curve_ = meta.at("curve").get<std::vector<std::string>>();
      has_best_ = !curve_.empty();
    } catch (const c10::Error&) {
      throw InputError(File("checkpoint.pt"), "training", "an unreadable checkpoint",
                       "one of this version: another folder, or --fresh");
    } catch (const Json::exception&) {
      throw InputError(File("checkpoint.pt"), "training", "an unreadable checkpoint",
                       "one of this version: another folder, or --fresh");
    }
    return true;
  }

  const TrainSettings settings_;
  const Shape shape_;
  Learner learner_;
  TrainProgress now_;
  TrainResult result_;
  bool has_best_ = false;
  std::vector<Episode> replay_;
  std::deque<double> returns_, losses_;
  std::vector<std::string> curve_;
};

}  // namespace

void SetUpLibtorch() {
  at::set_num_threads(1);
  // Large temporaries come and go at every step: without this, their pages do, too.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

double BlasSpeed() {
  const Tensor a = torch::ones({256, 256});
  torch::mm(a, a);
  double best_s = 1;
  for (int i = 0; i < 5; ++i) {
    const auto start = Clock::now();
    torch::mm(a, a);
    best_s = std::min(best_s, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return 2 * 256.0 * 256 * 256 / best_s / 1e9;
}

double RandomCompletion(const TrainSettings& settings) {
  return HeldOut(settings, ShapeOf(Generate(settings.scenario, kFirstHeldOut)), nullptr, 1);
}

TrainResult Train(const TrainSettings& settings,
                  const std::function<void(const TrainProgress&)>& say,
                  const std::function<bool()>& stop) {
  return Training(settings).Run(say, stop);
}

}  // namespace muster::learning

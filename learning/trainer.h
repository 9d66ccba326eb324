#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "model/generator.h"

namespace muster::learning {

/// How to train one model. Everything random is a function of `seed`.
struct TrainSettings {
  std::string method = "qmix";
  GeneratorSettings scenario;  ///< every episode is a mission of it, of another seed
  std::uint64_t seed = 1;
  double seconds = 1200;      ///< of the processor, those before a resumption counted
  std::int64_t episodes = 0;  ///< ends after so many, too; 0: by time alone
  std::string folder;
  bool resume = true;  ///< go on from a checkpoint, where there is one
  // Sources: docs/reference/learned.md.
  int batch = 8;              ///< episodes
  int replay = 1000;          ///< episodes
  int target_every = 100;     ///< episodes
  int look_every = 100;       ///< episodes between two looks at the held-out missions
  int held_out = 10;          ///< missions
  std::int64_t anneal = 500;  ///< episodes until exploring is down to its least; qtran 1200
  double most_random = 1, least_random = 0.05;
  double checkpoint_s = 60;
};

/// What is told while it trains.
struct TrainProgress {
  std::int64_t episodes = 0;
  double seconds = 0;
  double episode_return = 0;  ///< mean of the last 50 episodes, tasks
  double loss = 0;            ///< mean of the last 50
  double completion = 0;      ///< of the held-out missions, at the last look
  double best = 0;            ///< the most so far: that model is kept
  bool looked = false;        ///< whether this one comes with a fresh look
};

struct TrainResult {
  TrainProgress end;
  bool interrupted = false;
  bool resumed = false;
  std::string hash;  ///< SHA-256 of all weights
};

/// Trains, writes model.json and model.bin of the best model so far, curve.csv, curve.gp and
/// checkpoint.pt into the folder. `say` hears of it after every episode; `stop` is asked as often.
/// Throws InputError when the folder holds a checkpoint of other settings, SystemError.
TrainResult Train(const TrainSettings& settings,
                  const std::function<void(const TrainProgress&)>& say,
                  const std::function<bool()>& stop);

/// Completion of random choices, and of nothing else, on the same held-out missions.
double RandomCompletion(const TrainSettings& settings);

/// GFLOP/s of a product of matrices: an optimised BLAS has 20 and more.
double BlasSpeed();

/// One thread, fixed settings: to be called before anything else of this library.
void SetUpLibtorch();

}  // namespace muster::learning

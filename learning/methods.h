#pragma once

#include <memory>
#include <string>

#include "learning/mixers.h"
#include "learning/nets.h"

namespace muster::learning {

/// The learned methods of the paper's appendix B; kVdn, the plain sum, is a control for tests.
enum class Method { kMadl, kQmix, kCwQmix, kOwQmix, kQtran, kQplex, kMfQmix, kSqix, kVdn };

/// One of scheduler::learned::kMethodNames, or "marl", the paper's name of qmix. Throws InputError.
Method MethodOf(const std::string& name);

/// What methods are trained with. Sources: docs/reference/learned.md.
struct MethodSettings {
  Method method = Method::kQmix;
  double gamma = 0.99;
  double charge_worth = 0.5;  ///< MADL: reward per unit of urgency that charging takes away
  double alpha = 0.1;         ///< CW, OW: weight of the other joint actions
  double optimum_weight = 1, other_weight = 0.1;  ///< QTRAN: of L_opt and L_nopt
  int heads = 4, layers = 1;                      ///< QPLEX
  double inverse_temperature = 5;                 ///< SQIX
  std::int64_t near_actions = 4;                  ///< SQIX: others of each agent that it looks at
};

/// A situation through one set of networks.
struct Sight {
  Tensor e, present, available;
  Utilities own;
  Utilities central;  ///< CW, OW only
};
/// Those at `index` of a batch.
Sight Pick(const Sight& sight, const Tensor& index);

/// What has happened: one row a situation. `next` is the row of the situation that came of it; that
/// of an episode's last one is any.
struct Happened {
  Tensor actions;      ///< [B x N] options taken; 0 where absent
  Tensor reward;       ///< [B]
  Tensor charge_gain;  ///< [B] urgency that charging takes away
  Tensor done;         ///< [B] 1 at the end of an episode
  Tensor next;         ///< [B]
};

/// [B x N] values of the actions, 0 where absent.
Tensor ChosenOf(const Tensor& q, const Tensor& actions, const Tensor& present);
/// [B x N] each agent's best option.
Tensor BestActions(const Tensor& q, const Tensor& available);

/// How a method joins the agents' values, and what it makes them learn. Networks come twice: the
/// target's are a copy from time to time.
class Joiner : public torch::nn::Module {
 public:
  /// Q_tot of these actions [B], as the method's own networks have it.
  virtual Tensor Joint(const Sight& sight, const Tensor& actions) = 0;
  /// The loss of a batch. `now`, `old`: through the trained networks, and the target's. `target`:
  /// this with the target's numbers.
  virtual Tensor Loss(const Sight& now, const Sight& old, Joiner* target,
                      const Happened& happened) = 0;
  /// MADL learns what it is given alone.
  virtual bool needs_target() const { return true; }
  virtual bool needs_central() const { return false; }
};

/// SQIX's value of a situation [B]: the target's Q_tot, averaged over the best joint action and all
/// that change one agent's to one of its `near` next best, with weights softmax(inverse_temperature
/// * Q_tot) of the trained networks.
Tensor SqixValue(QmixMixer* trained, QmixMixer* target, const Sight& now, const Sight& old,
                 double inverse_temperature, std::int64_t near);

std::shared_ptr<Joiner> MakeJoiner(const MethodSettings& settings, const Problem& problem);

}  // namespace muster::learning

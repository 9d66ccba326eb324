#include "learning/methods.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/check.h"
#include "base/text.h"
#include "scheduler/policies/learned/model.h"

namespace muster::learning {
namespace {

using scheduler::learned::kMethodNames;

Tensor MeanSquare(const Tensor& error) { return error.square().mean(); }

/// What both networks are after: reward and the target's value of what is best afterwards.
Tensor TargetOf(const Happened& happened, double gamma, const Tensor& later) {
  return (happened.reward + gamma * (1 - happened.done) * later).detach();
}

/// HoCs-MARL: QMIX. Also VDN and, with other agents' networks, MF-QMIX.
class Qmix : public Joiner {
 public:
  Qmix(const MethodSettings& settings, const Problem& problem) : settings_(settings) {
    mixer_ =
        register_module("mixer", std::make_shared<QmixMixer>(problem.agents, problem.state_width));
  }
  Tensor Joint(const Sight& sight, const Tensor& actions) override {
    return mixer_->forward(ChosenOf(sight.own.q, actions, sight.present), sight.e);
  }
  Tensor Loss(const Sight& now, const Sight& old, Joiner* target,
              const Happened& happened) override {
    return MeanSquare(Joint(now, happened.actions) -
                      TargetOf(happened, settings_.gamma,
                               Later(Pick(now, happened.next), Pick(old, happened.next),
                                     static_cast<Qmix*>(target))));
  }

 protected:
  /// The target's value of the next situation.
  virtual Tensor Later(const Sight& now, const Sight& old, Qmix* target) {
    return target->Joint(old, BestActions(now.own.q, now.available));
  }

  MethodSettings settings_;
  std::shared_ptr<QmixMixer> mixer_;
};

/// HoCs-MADL: the same networks learn the reward at hand.
class Madl : public Qmix {
 public:
  using Qmix::Qmix;
  Tensor Loss(const Sight& now, const Sight&, Joiner*, const Happened& happened) override {
    return MeanSquare(Joint(now, happened.actions) - happened.reward -
                      settings_.charge_worth * happened.charge_gain);
  }
  bool needs_target() const override { return false; }
};

/// The sum: a control.
class Vdn : public Qmix {
 public:
  using Qmix::Qmix;
  Tensor Joint(const Sight& sight, const Tensor& actions) override {
    return ChosenOf(sight.own.q, actions, sight.present).sum(1);
  }
};

/// SQIX. Source: Pan et al. 2021, the paper's appendix B.
class Sqix : public Qmix {
 public:
  using Qmix::Qmix;

 protected:
  Tensor Later(const Sight& now, const Sight& old, Qmix* target) override {
    return SqixValue(mixer_.get(), static_cast<Sqix*>(target)->mixer_.get(), now, old,
                     settings_.inverse_temperature, settings_.near_actions);
  }
};

/// QPLEX.
class Qplex : public Joiner {
 public:
  Qplex(const MethodSettings& settings, const Problem& problem) : gamma_(settings.gamma) {
    mixer_ = register_module(
        "mixer", std::make_shared<QplexMixer>(problem.agents, problem.options, problem.state_width,
                                              settings.heads, settings.layers));
  }
  Tensor Joint(const Sight& sight, const Tensor& actions) override {
    const Tensor best = std::get<0>(Masked(sight.own.q, sight.available).max(2)) * sight.present;
    return mixer_->forward(ChosenOf(sight.own.q, actions, sight.present), best, actions,
                           sight.present, sight.e);
  }
  Tensor Loss(const Sight& now, const Sight& old, Joiner* target,
              const Happened& happened) override {
    const Tensor best = BestActions(now.own.q, now.available).index_select(0, happened.next);
    const Tensor later = target->Joint(Pick(old, happened.next), best);
    return MeanSquare(Joint(now, happened.actions) - TargetOf(happened, gamma_, later));
  }

 private:
  double gamma_;
  std::shared_ptr<QplexMixer> mixer_;
};

/// QTRAN-base. The reference's losses, not the paper's formulas: docs/reference/learned.md.
class Qtran : public Joiner {
 public:
  Qtran(const MethodSettings& settings, const Problem& problem) : settings_(settings) {
    joint_ = register_module("joint",
                             std::make_shared<QtranJoint>(problem.options, problem.state_width));
  }
  /// The sum that the joint value is made to agree with where it matters.
  Tensor Joint(const Sight& sight, const Tensor& actions) override {
    return ChosenOf(sight.own.q, actions, sight.present).sum(1) + joint_->V(sight.e);
  }
  Tensor Critic(const Sight& sight, const Tensor& actions) {
    return joint_->forward(sight.own.hidden, actions, sight.present, sight.e);
  }
  Tensor Loss(const Sight& now, const Sight& old, Joiner* target,
              const Happened& happened) override {
    const Tensor best = BestActions(now.own.q, now.available);
    const Tensor later = static_cast<Qtran*>(target)->Critic(Pick(old, happened.next),
                                                             best.index_select(0, happened.next));
    const Tensor critic = Critic(now, happened.actions);
    const Tensor td = MeanSquare(critic - TargetOf(happened, settings_.gamma, later));
    const Tensor optimum = MeanSquare(Joint(now, best) - Critic(now, best).detach());
    const Tensor other =
        MeanSquare(torch::clamp_max(Joint(now, happened.actions) - critic.detach(), 0.0));
    return td + settings_.optimum_weight * optimum + settings_.other_weight * other;
  }

 private:
  MethodSettings settings_;
  std::shared_ptr<QtranJoint> joint_;
};

/// CW-QMIX and OW-QMIX of Rashid et al. 2020: QMIX whose errors count less where it cannot help
/// being too high, beside an unrestricted Q^ that gives the target to both.
class Weighted : public Qmix {
 public:
  Weighted(const MethodSettings& settings, const Problem& problem) : Qmix(settings, problem) {
    central_ = register_module("central",
                               std::make_shared<FreeMixer>(problem.agents, problem.state_width));
  }
  bool needs_central() const override { return true; }
  Tensor Central(const Sight& sight, const Tensor& actions) {
    return central_->forward(ChosenOf(sight.central.q, actions, sight.present), sight.e);
  }
  Tensor Loss(const Sight& now, const Sight& old, Joiner* target,
              const Happened& happened) override {
    auto* const theirs = static_cast<Weighted*>(target);
    const Tensor best = BestActions(now.own.q, now.available);
    const Tensor later =
        theirs->Central(Pick(old, happened.next), best.index_select(0, happened.next));
    const Tensor y = TargetOf(happened, settings_.gamma, later);
    const Tensor total = Joint(now, happened.actions);
    const Tensor counts = settings_.method == Method::kOwQmix
                              ? total.detach() < y
                              : ((happened.actions == best) | (now.present == 0)).all(1) |
                                    (y > theirs->Central(old, best).detach());
    const Tensor weight =
        torch::where(counts, torch::ones_like(y), torch::full_like(y, settings_.alpha));
    return (weight * (total - y).square()).mean() + MeanSquare(Central(now, happened.actions) - y);
  }

 private:
  std::shared_ptr<FreeMixer> central_;
};

}  // namespace

Method MethodOf(const std::string& name) {
  if (name == "marl") return Method::kQmix;
  const auto found = std::find(kMethodNames.begin(), kMethodNames.end(), name);
  if (found == kMethodNames.end()) {
    throw InputError(
        "command line", "--policy", name,
        fmt::format("one of {}{}", fmt::join(kMethodNames, ", "), DidYouMean(name, kMethodNames)));
  }
  return static_cast<Method>(found - kMethodNames.begin());
}

Sight Pick(const Sight& sight, const Tensor& index) {
  const auto take = [&](const Tensor& tensor) {
    return tensor.defined() ? tensor.index_select(0, index) : tensor;
  };
  return {take(sight.e),
          take(sight.present),
          take(sight.available),
          {take(sight.own.q), take(sight.own.hidden)},
          {take(sight.central.q), take(sight.central.hidden)}};
}

Tensor ChosenOf(const Tensor& q, const Tensor& actions, const Tensor& present) {
  return q.gather(2, actions.unsqueeze(2)).squeeze(2) * present;
}

Tensor BestActions(const Tensor& q, const Tensor& available) {
  return Masked(q.detach(), available).argmax(2);
}

Tensor SqixValue(QmixMixer* trained, QmixMixer* target, const Sight& now, const Sight& old,
                 double inverse_temperature, std::int64_t near) {
  const torch::NoGradGuard guard;
  const Tensor best = BestActions(now.own.q, now.available);
  const auto k = std::min<std::int64_t>(near, now.own.q.size(2) - 1);
  const Tensor others = Masked(now.own.q, now.available).scatter(2, best.unsqueeze(2), -2e9);
  const Tensor actions = std::get<1>(others.topk(k, 2));  // [B x N x k]
  const Tensor usable = now.available.gather(2, actions) & (now.present > 0).unsqueeze(2);
  const auto totals = [&](QmixMixer* mixer, const Sight& sight) {
    const Tensor q = ChosenOf(sight.own.q, best, sight.present);
    const Tensor deviations =
        mixer->Deviations(q, sight.own.q.gather(2, actions) * sight.present.unsqueeze(2), sight.e);
    return torch::cat({mixer->forward(q, sight.e).unsqueeze(1), deviations.flatten(1)}, 1);
  };
  const Tensor mine = totals(trained, now);
  const Tensor mask =
      torch::cat({torch::ones({mine.size(0), 1}, torch::kBool), usable.flatten(1)}, 1);
  const Tensor weights = torch::softmax(Masked(inverse_temperature * mine, mask), 1);
  return (weights * totals(target, old)).sum(1);
}

std::shared_ptr<Joiner> MakeJoiner(const MethodSettings& settings, const Problem& problem) {
  switch (settings.method) {
    case Method::kMadl:
      return std::make_shared<Madl>(settings, problem);
    case Method::kVdn:
      return std::make_shared<Vdn>(settings, problem);
    case Method::kQmix:
    case Method::kMfQmix:
      return std::make_shared<Qmix>(settings, problem);
    case Method::kSqix:
      return std::make_shared<Sqix>(settings, problem);
    case Method::kQplex:
      return std::make_shared<Qplex>(settings, problem);
    case Method::kQtran:
      return std::make_shared<Qtran>(settings, problem);
    case Method::kCwQmix:
    case Method::kOwQmix:
      return std::make_shared<Weighted>(settings, problem);
  }
  return nullptr;
}

}  // namespace muster::learning

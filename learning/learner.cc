#include "learning/learner.h"

#include <torch/nn/utils/clip_grad.h>
#include <torch/serialize.h>

#include "base/sha256.h"

namespace muster::learning {

std::vector<std::shared_ptr<torch::nn::Module>> Learner::Networks::modules() const {
  std::vector<std::shared_ptr<torch::nn::Module>> list = {state, agents, joiner};
  if (central) list.push_back(central);
  return list;
}

Learner::Learner(const LearnerSettings& settings, const Problem& problem) : settings_(settings) {
  torch::manual_seed(settings.seed);
  const bool mean_field = settings.method.method == Method::kMfQmix;
  for (Networks* networks : {&trained_, &target_}) {
    networks->state = problem.state_net();
    networks->agents = problem.agent_nets(mean_field);
    networks->joiner = MakeJoiner(settings.method, problem);
    if (networks->joiner->needs_central()) networks->central = problem.agent_nets(false);
  }
  CopyToTarget();
  optimizer_ = std::make_unique<torch::optim::RMSprop>(
      Parameters(trained_),
      torch::optim::RMSpropOptions(settings.learning_rate).alpha(0.99).eps(1e-5));
}

std::vector<Tensor> Learner::Parameters(const Networks& networks) const {
  std::vector<Tensor> parameters;
  for (const auto& module : networks.modules()) {
    for (const Tensor& parameter : module->parameters()) parameters.push_back(parameter);
  }
  return parameters;
}

Sight Learner::See(Networks* networks, const Seen& seen) {
  Sight sight;
  sight.e = networks->state->Encode(seen);
  sight.present = seen.present;
  sight.available = seen.available;
  sight.own = networks->agents->Value(seen, sight.e);
  if (networks->central) sight.central = networks->central->Value(seen, sight.e);
  return sight;
}

double Learner::Update(const Seen& seen, const Happened& happened) {
  const Sight now = See(&trained_, seen);
  Sight old;
  if (trained_.joiner->needs_target()) {
    const torch::NoGradGuard guard;
    old = See(&target_, seen);
  }
  const Tensor loss = trained_.joiner->Loss(now, old, target_.joiner.get(), happened);
  optimizer_->zero_grad();
  loss.backward();
  torch::nn::utils::clip_grad_norm_(Parameters(trained_), settings_.most_gradient);
  optimizer_->step();
  return loss.item<double>();
}

void Learner::CopyToTarget() {
  const torch::NoGradGuard guard;
  const std::vector<Tensor> from = Parameters(trained_), to = Parameters(target_);
  for (std::size_t i = 0; i < from.size(); ++i) to[i].copy_(from[i]);
}

std::string Learner::Hash() const {
  std::string bytes;
  for (const Tensor& parameter : Parameters(trained_)) {
    const Tensor value = parameter.detach().contiguous();
    bytes.append(static_cast<const char*>(value.data_ptr()), value.nbytes());
  }
  return Sha256(bytes);
}

void Learner::Save(torch::serialize::OutputArchive* archive) const {
  const auto add = [&](const std::string& name, const Networks& networks) {
    const std::vector<Tensor> list = Parameters(networks);
    for (std::size_t i = 0; i < list.size(); ++i) {
      archive->write(name + std::to_string(i), list[i].detach());
    }
  };
  add("trained", trained_);
  add("target", target_);
  torch::serialize::OutputArchive optimizer;
  optimizer_->save(optimizer);
  archive->write("optimizer", optimizer);
}

void Learner::Load(torch::serialize::InputArchive* archive) {
  const torch::NoGradGuard guard;
  const auto take = [&](const std::string& name, const Networks& networks) {
    const std::vector<Tensor> list = Parameters(networks);
    for (std::size_t i = 0; i < list.size(); ++i) {
      Tensor value;
      archive->read(name + std::to_string(i), value);
      TORCH_CHECK(value.sizes() == list[i].sizes(), "another network");
      list[i].copy_(value);
    }
  };
  take("trained", trained_);
  take("target", target_);
  torch::serialize::InputArchive optimizer;
  archive->read("optimizer", optimizer);
  optimizer_->load(optimizer);
}

}  // namespace muster::learning

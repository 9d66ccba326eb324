#include "tools/orders/order_signer.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/text_file.h"
#include "model/person.h"
#include "model/scenario_json.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t RunIdOf(const std::string& run) {
  const std::string file = (std::filesystem::path(run) / "manifest.json").string();
  const Json manifest = Json::parse(ReadTextFile(file, "the run's id", 1 << 20), nullptr, false);
  if (!manifest.is_object() || !manifest.contains("run_id") ||
      !manifest["run_id"].is_number_integer()) {
    throw InputError(file, "run_id", "no such number", "the manifest of a mission");
  }
  return manifest["run_id"].get<std::int64_t>();
}

}  // namespace

void AddSignOption(Options* options) {
  options->Add("sign", "FILE",
               "Your key, where the mission takes orders of known persons only (muster person; "
               "docs/guide/persons.md)");
}

std::string SigningKeyFile(const Arguments& arguments) {
  return arguments.Has("sign") ? arguments.Get("sign") : "";
}

OrderSigner::OrderSigner(const std::string& key_file, const std::string& run)
    : key_(LoadPersonKey(key_file)),
      run_id_(RunIdOf(run)),
      origin_(LoadScenario((std::filesystem::path(run) / "scenario.json").string()).origin) {}

std::string OrderSigner::Sign(const std::string& order) const {
  world::PlannedOrder planned;
  try {
    planned = ReadOrder(order, "order", origin_);
  } catch (const InputError&) {
    return order;
  }
  planned.order.issuer = IssuerText(planned.order.issuer, key_.name);
  SignedOrder parts{planned.json, key_.name, key_.name, ""};
  parts.signature =
      key_.key.Sign(TextToSign(run_id_, planned.order.id, planned.order.issuer, parts));
  Json json = {{"id", planned.order.id}, {"issuer", planned.order.issuer}};
  json.update(Json::parse(planned.json));
  json["signed"] = {{"by", parts.by}, {"signature", parts.signature}};
  return json.dump();
}

}  // namespace muster::tools

// Who may order, as the log says it, and whether every order that was taken is signed by them.
#include <sodium.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

using nlohmann::json;

constexpr const char* kLauncher = "launcher";

/// 0 to 3; -1: no role.
int RankOf(const std::string& role) {
  const std::string ranks[] = {"none", "watch", "order", "control"};
  for (int rank = 0; rank < 4; ++rank) {
    if (role == ranks[rank]) return rank;
  }
  return -1;
}

std::string Bytes(const std::string& digits) {
  std::string bytes(digits.size() / 2, '\0');
  std::size_t n = 0;
  const int wrong = sodium_hex2bin(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(),
                                   digits.data(), digits.size(), nullptr, &n, nullptr);
  return wrong == 0 && n == bytes.size() ? bytes : "";
}

bool HasSigned(const std::string& key, const std::string& signature, const std::string& text) {
  const std::string public_key = Bytes(key), proof = Bytes(signature);
  return public_key.size() == crypto_sign_PUBLICKEYBYTES && proof.size() == crypto_sign_BYTES &&
         crypto_sign_verify_detached(
             reinterpret_cast<const unsigned char*>(proof.data()),
             reinterpret_cast<const unsigned char*>(text.data()), text.size(),
             reinterpret_cast<const unsigned char*>(public_key.data())) == 0;
}

/// Whether the world itself gives such an order, which nobody signs. Else somebody could put the
/// world's name over an order of a person.
bool IsOfTheWorld(const std::string& what, const taken_order_t& taken) {
  const std::pair<const char*, const char*> own[] = {
      {"road_close", "closure:"}, {"road_close", "fault:"}, {"road_open", "open:"},
      {"zone_add", "zone:"},      {"zone_lift", "lift:"},   {"task_add", "revisit:"},
      {"release", "release:"},    {"decide_now", "decide:"}};
  return taken.issuer == kWorld &&
         std::any_of(std::begin(own), std::end(own), [&](const auto& one) {
           return what == one.first && taken.id.starts_with(one.second);
         });
}

}  // namespace

std::string SignatureCheck::WrongOf(const taken_order_t& taken, std::int64_t run_id) {
  const json order = json::parse(taken.json);
  const std::string what = order.at("order").get<std::string>();
  const bool is_person = what == "person";
  if (IsOfTheWorld(what, taken) || (persons_.empty() && !is_person)) return "";
  if (persons_.empty()) {
    if (order.at("name") != kLauncher) return "names a person before the launcher";
    persons_[kLauncher] = {RankOf(order.at("role")), order.at("key")};
  }
  if (!order.contains("signed")) return "is not signed";
  const std::string by = order.at("signed").at("by"), key = order.at("signed").at("key");
  const auto person = persons_.find(by), signer = persons_.find(key);
  if (person == persons_.end() || signer == persons_.end() || (key != by && key != kLauncher)) {
    return "is signed by nobody whom the mission knows";
  }
  const bool is_simple = what.starts_with("task_") || what == "withdraw";
  if (person->second.rank < (is_simple ? 2 : 3) || (is_person && by != kLauncher)) {
    return "is " + by + "'s, who may not give it";
  }
  const std::size_t end = taken.json.rfind(",\"signed\":");
  const std::string text = "MUSTER_ORDER\n" + std::to_string(run_id) + "\n" + taken.id + "\n" +
                           taken.issuer + "\n" + by + "\n" + taken.json.substr(0, end) + "}";
  if (!HasSigned(signer->second.key, order.at("signed").at("signature"), text)) {
    return "has a signature that is not " + by + "'s";
  }
  if (is_person) {
    persons_[order.at("name")] = {RankOf(order.at("role")), order.value("key", "")};
  }
  return "";
}

void SignatureCheck::Check(View& view) {
  if (!view.said->orders) return;
  for (const taken_order_t& taken : view.said->orders->taken) {
    std::string wrong;
    try {
      wrong = WrongOf(taken, view.said->orders->header.run_id);
    } catch (const std::exception& error) {
      wrong = std::string("cannot be read: ") + error.what();
    }
    if (!wrong.empty()) view.Violate("orders", "order {}: {}", taken.id, wrong);
  }
}

}  // namespace muster::tools::audit

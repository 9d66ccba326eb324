#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "lcmtypes/bus/signing.h"
#include "model/generator.h"
#include "model/person.h"
#include "model/scenario_json.h"
#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

constexpr std::int64_t kRun = 77;

/// A mission whose launcher knows Chief (all orders) and Ann (tasks only); Eve is nobody.
class Signatures : public ::testing::Test {
 protected:
  Signatures()
      : view_(ParseScenario(ScenarioToJson(Generate(PresetByName("Random_1"), 1))), &findings_) {
    for (const char* name : {"launcher", "Chief", "Ann", "Eve"}) {
      keys_.emplace(name, SigningKey::Fresh());
    }
    // The launcher's own key comes first; it signs all others.
    EXPECT_EQ(WrongOf(Taken(Introduces("launcher", "control"), "launcher", "launcher")), "");
    EXPECT_EQ(WrongOf(Taken(Introduces("Chief", "control"), "launcher", "launcher")), "");
    EXPECT_EQ(WrongOf(Taken(Introduces("Ann", "order"), "launcher", "launcher")), "");
  }
  std::string Introduces(const std::string& name, const std::string& role) const {
    return fmt::format(R"({{"order":"person","name":"{}","role":"{}","key":"{}"}})", name, role,
                       keys_.at(name).Public());
  }
  /// `by` answers for the order, and `key` has signed it.
  taken_order_t Taken(const std::string& json, const std::string& by, const std::string& key) {
    SignedOrder order{json, by, key, ""};
    taken_order_t taken{};
    taken.id = fmt::format("o{}", ++n_);
    taken.issuer = by;
    order.signature = keys_.at(key).Sign(TextToSign(kRun, taken.id, taken.issuer, order));
    taken.json = ToJson(order);
    return taken;
  }
  /// What the audit says of an order that the world has taken; "": nothing.
  std::string WrongOf(const taken_order_t& taken) {
    TickFacts facts;
    facts.orders.emplace();
    facts.orders->header.run_id = kRun;
    facts.orders->taken = {taken};
    view_.said = &facts;
    const std::size_t before = findings_.count();
    check_.Check(view_);
    return findings_.count() == before ? "" : findings_.Sorted().back().text;
  }

  Findings findings_;
  View view_;
  SignatureCheck check_;
  std::map<std::string, SigningKey> keys_;
  int n_ = 0;
};

constexpr const char* kCancel = R"({"order":"task_cancel","task":3})";
constexpr const char* kCharge = R"({"order":"charge_now","uav":3})";

TEST_F(Signatures, OfThoseWhoMayGiveTheOrderAreRight) {
  EXPECT_EQ(WrongOf(Taken(kCancel, "Ann", "Ann")), "");
  EXPECT_EQ(WrongOf(Taken(kCharge, "Chief", "Chief")), "");
  EXPECT_EQ(WrongOf(Taken(kCharge, "Chief", "launcher")), "") << "the launcher signs for a person";
}

TEST_F(Signatures, OfOthersAreNot) {
  const std::string nobody = "is signed by nobody whom the mission knows";
  EXPECT_NE(WrongOf(Taken(kCancel, "Eve", "Eve")).find(nobody), std::string::npos);
  EXPECT_NE(WrongOf(Taken(kCancel, "Ann", "Eve")).find(nobody), std::string::npos);
  EXPECT_NE(WrongOf(Taken(kCancel, "Ann", "Chief")).find(nobody), std::string::npos)
      << "a person does not sign for another";
  EXPECT_NE(WrongOf(Taken(kCharge, "Ann", "Ann")).find("is Ann's, who may not give it"),
            std::string::npos);
  EXPECT_NE(WrongOf(Taken(Introduces("Eve", "control"), "Chief", "Chief"))
                .find("is Chief's, who may not give it"),
            std::string::npos);
}

TEST_F(Signatures, OfAnotherTextRunOrOrderAreNot) {
  const std::string not_anns = "has a signature that is not Ann's";
  taken_order_t taken = Taken(kCancel, "Ann", "Ann");
  taken.json.replace(taken.json.find('3'), 1, "4");
  EXPECT_NE(WrongOf(taken).find(not_anns), std::string::npos);
  taken = Taken(kCancel, "Ann", "Ann");
  taken.id += "0";
  EXPECT_NE(WrongOf(taken).find(not_anns), std::string::npos);
  taken = Taken(kCancel, "Ann", "Ann");
  taken.issuer = "Mayor";
  EXPECT_NE(WrongOf(taken).find(not_anns), std::string::npos);
  taken = Taken(kCancel, "Ann", "Ann");
  taken.json = kCancel;
  EXPECT_NE(WrongOf(taken).find("is not signed"), std::string::npos);
}

TEST_F(Signatures, TheWorldsOwnOrdersNeedNone) {
  taken_order_t taken{};
  taken.id = "closure:3";
  taken.issuer = "world";
  taken.json = R"({"order":"road_close"})";
  EXPECT_EQ(WrongOf(taken), "");
  taken.json = kCancel;
  EXPECT_NE(WrongOf(taken).find("is not signed"), std::string::npos) << "nor with its name over it";
}

}  // namespace
}  // namespace muster::tools::audit

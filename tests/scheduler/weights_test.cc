#include "scheduler/weights.h"

#include <gtest/gtest.h>

#include <cmath>

namespace muster::scheduler {
namespace {

TEST(Softplus, KnownValuesAndExtremes) {
  EXPECT_NEAR(Softplus(0), 0.6931471805599453, 1e-15);  // ln 2
  EXPECT_NEAR(Softplus(1), 1.3132616875182228, 1e-15);  // ln(1 + e) = ln 3.718281828
  EXPECT_EQ(Softplus(100), 100.0);                      // + e^-100 = 4e-44
  EXPECT_EQ(Softplus(1e300), 1e300);
  EXPECT_NEAR(Softplus(-50), std::exp(-50.0), 1e-35);
  EXPECT_EQ(Softplus(-1e300), 0.0);
}

// Eq. 4-1
TEST(TaskLikelihood, IsConcaveInTheShareOfRange) {
  // (1 - e^-0.5) / (1 - e^-1) = 0.3934693403 / 0.6321205588
  EXPECT_NEAR(TaskLikelihood(0.5), 0.6224593312018546, 1e-15);
  EXPECT_NEAR(TaskLikelihood(1), 1.0, 1e-15);
  EXPECT_EQ(TaskLikelihood(0), 1e-6);  // clamped
  // Eq. 4-2, 4-3: it rises, ever more slowly.
  for (double s = 0.1; s < 0.95; s += 0.05) {
    EXPECT_GT(TaskLikelihood(s + 0.05), TaskLikelihood(s));
    EXPECT_LT(TaskLikelihood(s + 0.05) - TaskLikelihood(s),
              TaskLikelihood(s) - TaskLikelihood(s - 0.05));
  }
}

// Eq. 4-4
TEST(ChargeLikelihood, MirrorsTheTaskLikelihood) {
  // (1 - e^-0.75) / (1 - e^-1) = 0.5276334473 / 0.6321205588
  EXPECT_NEAR(ChargeLikelihood(0.25), 0.8347038233, 1e-10);
  EXPECT_NEAR(ChargeLikelihood(0), 1.0, 1e-15);
  EXPECT_EQ(ChargeLikelihood(1), 1e-6);  // a full UAV hardly needs any: clamped
}

// Eq. 4-10, 4-12, 4-14, 4-17
TEST(MoveBenefit, IsTheRelativeGainPerInterval) {
  // Softplus((4 - 2) / 4) / 2 = ln(1 + e^0.5) / 2 = ln(2.6487212707) / 2
  EXPECT_NEAR(MoveBenefit(4, 2, 2), 0.48703849209005334, 1e-15);
  EXPECT_NEAR(MoveBenefit(4, 4, 1), std::log(2.0), 1e-15);      // as staying
  EXPECT_NEAR(MoveBenefit(0, 0, 3), std::log(2.0) / 3, 1e-15);  // 0 / 0 counts 0
  EXPECT_EQ(MoveBenefit(0, 1, 1), 0.0);                         // infinitely worse
}

// Eq. 4-15
TEST(UavBenefit, WeighsByTheRangeLeft) {
  EXPECT_NEAR(UavBenefit(5000, 20000, 0.8, 0.4), 0.5, 1e-15);  // 0.25 * 0.8 + 0.75 * 0.4
  EXPECT_EQ(UavBenefit(0, 0, 0.8, 0.4), 0.4);
}

// Eq. 4-18
TEST(SenseFoundation, IsAHundredOrUniform) {
  EXPECT_EQ(SenseFoundation(Foundation::kHierarchical), 100.0);
  // Section 5.3.3: Softplus(1) = ln(1 + e)
  EXPECT_NEAR(SenseFoundation(Foundation::kUniform), 1.3132616875182228, 1e-15);
}

// Eq. 4-19
TEST(ChargeFoundation, GrowsAsRangeFalls) {
  // Softplus(10 + e^0.5) = 11.6487212707 + ln(1 + e^-11.6487212707) = 11.6487212707 + 0.0000087302
  EXPECT_NEAR(ChargeFoundation(Foundation::kHierarchical, 0.5), 11.648730000870822, 1e-13);
  // Softplus(e^0.5 / e) = ln(1 + e^0.6065306597)
  EXPECT_NEAR(ChargeFoundation(Foundation::kUniform, 0.5), 1.0417093877814123, 1e-14);
  EXPECT_GT(ChargeFoundation(Foundation::kHierarchical, 0.1),
            ChargeFoundation(Foundation::kHierarchical, 0.9));
}

}  // namespace
}  // namespace muster::scheduler

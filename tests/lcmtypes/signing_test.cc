#include "lcmtypes/bus/signing.h"

#include <gtest/gtest.h>

#include "base/check.h"

namespace muster {
namespace {

/// RFC 8032, section 7.1, test 2: its message is the one byte 0x72.
TEST(Signing, HasTheValuesOfItsStandard) {
  const SigningKey key = SigningKey::Parse(
      "4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb", "RFC 8032");
  EXPECT_EQ(key.Public(), "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c");
  const std::string signature =
      "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da"
      "085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00";
  EXPECT_EQ(key.Sign("r"), signature);
  EXPECT_TRUE(IsSignature(signature, "r", key.Public()));
}

TEST(Signing, NothingElseIsASignature) {
  const SigningKey key = SigningKey::Fresh();
  const std::string signature = key.Sign("order");
  ASSERT_TRUE(IsSignature(signature, "order", key.Public()));
  EXPECT_EQ(SigningKey::Parse(key.Secret(), "test").Public(), key.Public());
  EXPECT_FALSE(IsSignature(signature, "orders", key.Public()));
  EXPECT_FALSE(IsSignature(signature, "order", SigningKey::Fresh().Public()));
  EXPECT_FALSE(IsSignature(signature, "order", ""));
  EXPECT_FALSE(IsSignature("", "order", key.Public()));
  EXPECT_FALSE(IsSignature(signature.substr(2), "order", key.Public()));
  for (std::size_t i = 0; i < signature.size(); ++i) {
    std::string other = signature;
    other[i] = other[i] == '0' ? '1' : '0';
    EXPECT_FALSE(IsSignature(other, "order", key.Public())) << i;
  }
  for (const char* text : {"", "x", "4ccd"}) {
    EXPECT_THROW(SigningKey::Parse(text, "test"), InputError) << text;
  }
}

}  // namespace
}  // namespace muster

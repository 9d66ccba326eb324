#include "base/command_text.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace muster {
namespace {

TEST(CommandText, CommandsAreSplitIntoWords) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(WordsOf("a  b"), (Words{"a", "b"}));
  EXPECT_EQ(WordsOf(R"(a 'b c' "d 'e" f\ g '' 'h\i')"),
            (Words{"a", "b c", "d 'e", "f g", "", R"(h\i)"}));
  EXPECT_EQ(WordsOf("  "), Words());
  EXPECT_EQ(WordsOf("a 'b"), std::nullopt);
}

TEST(CommandText, QuotesAreFitForAMessage) {
  EXPECT_EQ(Quote("a\xc3\x28\n\x7f"), R"(a\xc3(\x0a\x7f)");
  const std::string cut = Quote(std::string(501, 'x'));
  EXPECT_EQ(cut.size(), 503U);
  EXPECT_TRUE(cut.ends_with("xx..."));
}

}  // namespace
}  // namespace muster

#include "base/object_reader.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "base/check.h"

namespace muster {
namespace {

/// What reading `json` in that way is refused with.
std::string Refusal(const std::string& json, const std::function<void(const ObjectReader&)>& read) {
  try {
    const JsonValue value = ParseJson(json, "f.json");
    read(ObjectReader(value, "", "f.json"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(ObjectReader, NamesFileKeyLineColumnFoundAndExpected) {
  const std::string json =
      "{\n  \"a\": [{\"n\": 1}, {\"n\": \"two\"}],\n  \"b\":  -12.5,\n  \"c\": tru";
  const std::string whole = json + "e,\n \"d\": \"say \\\"no\\\" \\\\\"\n}\n";
  const auto second = [](const ObjectReader& top) {
    const auto& items = top.Array("a");
    top.Element("a", items[1], 1).Integer("n", 0, 9);
  };
  EXPECT_EQ(Refusal(whole, second),
            "f.json: a[1].n (line 2, column 25): found \"two\", expected an integer in [0, 9]");
  EXPECT_EQ(Refusal(whole, [](const ObjectReader& top) { top.Number("b", kOne, 0, 1); }),
            "f.json: b (line 3, column 9): found -12.5, expected a number in [0, 1]");
  EXPECT_EQ(Refusal(whole, [](const ObjectReader& top) { top.String("c"); }),
            "f.json: c (line 4, column 8): found true, expected a string");
  EXPECT_EQ(Refusal(whole, [](const ObjectReader& top) { top.Boolean("d", false); }),
            "f.json: d (line 5, column 7): found \"say \\\"no\\\" \\\\\", expected true or false");
  EXPECT_EQ(
      Refusal(whole,
              [](const ObjectReader& top) {
                top.AllowOnly({"a", "b", "c"});
              }),
      "f.json: top level (line 5, column 7): found the unknown key \"d\", expected only a, b, c");
  EXPECT_EQ(Refusal(whole, [](const ObjectReader& top) { top.Child("a"); }),
            "f.json: a (line 2, column 8): found an array of 2, expected an object");
  EXPECT_EQ(Refusal(whole, [](const ObjectReader& top) { top.Required("e", "a value"); }),
            "f.json: e (line 1, column 1): found no such key, expected a value");
}

TEST(ObjectReader, SaysNoPositionInATextOfOneLine) {
  EXPECT_EQ(Refusal("{\"n\": 1.5}\n", [](const ObjectReader& top) { top.Integer("n", 0, 9); }),
            "f.json: n: found 1.5, expected an integer in [0, 9]");
  EXPECT_EQ(Refusal("[]", [](const ObjectReader&) {}),
            "f.json: top level: found an array of 0, expected an object");
}

TEST(ObjectReader, ReadsWhatIsThere) {
  const JsonValue value =
      ParseJson(R"({"km": 1.5, "min": 2, "n": 7, "yes": true, "text": "t", "version": 1})", "f");
  const ObjectReader object(value, "", "f");
  EXPECT_EQ(object.Number("km", kKm), 1500);
  EXPECT_EQ(object.Time("min", kMinute), 2 * kMinuteUs);
  EXPECT_EQ(object.Integer("n", 0, 7), 7);
  EXPECT_TRUE(object.Boolean("yes", false));
  EXPECT_TRUE(object.Boolean("no", true));
  EXPECT_EQ(object.String("text"), "t");
  EXPECT_TRUE(object.Has("n"));
  EXPECT_FALSE(object.Has("m"));
  object.Expect("version", 1);
  EXPECT_THROW(object.Expect("version", 2), InputError);
  EXPECT_THROW(object.Integer("n", 0, 6), InputError);
  EXPECT_THROW(object.Integer("n", 8, 9), InputError);
}

}  // namespace
}  // namespace muster

#include "base/options.h"

#include <gtest/gtest.h>

#include "base/check.h"

namespace muster {
namespace {

Options Declared() {
  Options options("muster try", "Tries.");
  options.Scenario();
  options.Out("FILE", "File to write");
  options.Json();
  options.Quiet();
  options.Add("share", "P", "A share").Number({0, 1, false, true}).Default(0.25);
  options.Add("rate", "R", "A rate").Number(Above0()).Or("max").Default("max");
  options.Add("count", "N", "A count").Integer(1, 10);
  options.Add("seed", "N", "A seed").Seed().Default(1);
  options.Add("on-loss", "wait|continue", "What then").OneOf({"wait", "continue"}).Default("wait");
  options.Add("scales", "X,...", "Scales").List().Number(Above0()).Default("1,2.5");
  options.Add("where", "FILTER", "Filters").Repeated();
  options.Add("live", "PORT", "A port").Integer(0, 65535).Implied("8087");
  return options;
}

std::optional<Arguments> Parse(std::vector<const char*> words) {
  words.insert(words.begin(), "muster try");
  return Declared().Parse(static_cast<int>(words.size()), words.data());
}

std::string ErrorOf(const std::vector<const char*>& words) {
  try {
    Parse(words);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string HelpOf(const char* flag) {
  ::testing::internal::CaptureStdout();
  EXPECT_FALSE(Parse({flag}));
  return ::testing::internal::GetCapturedStdout();
}

TEST(Options, GivesDefaultsToWhatIsNotGiven) {
  const Arguments arguments = Parse({"a.json"}).value();
  EXPECT_EQ(arguments.Get("scenario"), "a.json");
  EXPECT_EQ(arguments.Get<double>("share"), 0.25);
  EXPECT_EQ(arguments.Get("rate"), "max");
  EXPECT_EQ(arguments.Get<std::uint64_t>("seed"), 1u);
  EXPECT_EQ(arguments.All<double>("scales"), (std::vector<double>{1, 2.5}));
  EXPECT_TRUE(arguments.All("where").empty());
  EXPECT_FALSE(arguments.Has("json"));
  EXPECT_FALSE(arguments.Has("share"));
  std::string out = "as it was";
  std::optional<int> count;
  arguments.Read("out", &out);
  arguments.Read("count", &count);
  EXPECT_EQ(out, "as it was");
  EXPECT_EQ(count, std::nullopt);
}

TEST(Options, ReadsWhatIsGiven) {
  const Arguments arguments =
      Parse({"--scales",  "3,4",       "a.json",  "-o",         "page.html", "-q",
             "--share=0", "--rate",    "1e2",     "--count=10", "--seed",    "18446744073709551615",
             "--where",   "a=b,c",     "--where", "d=e",        "--live",    "--scales",
             "5",         "--on-loss", "wait",    "--on-loss",  "continue"})
          .value();
  EXPECT_EQ(arguments.Get("out"), "page.html");
  EXPECT_TRUE(arguments.Has("quiet"));
  EXPECT_EQ(arguments.Get<double>("share"), 0);
  EXPECT_EQ(arguments.Get<double>("rate"), 100);
  EXPECT_EQ(arguments.Get<int>("count"), 10);
  EXPECT_EQ(arguments.Get<std::uint64_t>("seed"), 18446744073709551615u);
  EXPECT_EQ(arguments.All("where"), (std::vector<std::string>{"a=b,c", "d=e"}));
  EXPECT_EQ(arguments.All<double>("scales"), (std::vector<double>{3, 4, 5}));
  EXPECT_EQ(arguments.Get<int>("live"), 8087);
  EXPECT_EQ(arguments.Get("on-loss"), "continue") << "the last one holds";
  EXPECT_EQ(Parse({"a.json", "--live=0"})->Get<int>("live"), 0);
}

TEST(Options, RefusesWhatIsNoNumberOfTheRange) {
  for (const char* text :
       {"", "x", "nan", "-nan", "inf", "1e400", "0.5x", " 0.5", "0x1", "-0.1", "1", "0,5"}) {
    EXPECT_EQ(
        ErrorOf({"a.json", "--share", text}),
        "command line: --share: found '" + std::string(text) + "', expected a number in [0, 1)");
  }
  for (const char* text : {"", "0", "11", "-1", "1.5", "1e1", "5 ", "99999999999999999999"}) {
    EXPECT_EQ(
        ErrorOf({"a.json", "--count", text}),
        "command line: --count: found '" + std::string(text) + "', expected an integer in [1, 10]");
  }
  for (const char* text : {"", "-1", "1.0", "18446744073709551616", "1x"}) {
    EXPECT_EQ(ErrorOf({"a.json", "--seed", text}),
              "command line: --seed: found '" + std::string(text) +
                  "', expected an integer in [0, 18446744073709551615]");
  }
  for (const char* text : {"0", "maximal", "inf", ""}) {
    EXPECT_NE(ErrorOf({"a.json", "--rate", text}), "") << text;
  }
  EXPECT_EQ(ErrorOf({"a.json", "--rate", "fast"}),
            "command line: --rate: found 'fast', expected max or a number above 0");
  EXPECT_EQ(ErrorOf({"a.json", "--scales", "1,,2"}),
            "command line: --scales: found '', expected a number above 0");
}

TEST(Options, RefusesWhatIsMissingOrTooMuch) {
  EXPECT_EQ(ErrorOf({}), "command line: SCENARIO: found nothing, expected a scenario file");
  EXPECT_EQ(ErrorOf({"a.json", "b.json"}), "unexpected argument 'b.json' (see --help)");
  EXPECT_EQ(ErrorOf({"a.json", "--out", ""}), "command line: --out: found '', expected FILE");
  EXPECT_EQ(ErrorOf({"a.json", "--json=false"}),
            "command line: --json: found 'false', expected no value");
  EXPECT_NE(ErrorOf({"a.json", "--out"}).find("(see --help)"), std::string::npos);
}

TEST(Options, NamesWhatTheUserMayHaveMeant) {
  EXPECT_EQ(ErrorOf({"--shrae", "0.5", "a.json"}), "no option '--shrae' (did you mean '--share'?)");
  EXPECT_EQ(ErrorOf({"a.json", "--sead=3"}), "no option '--sead' (did you mean '--seed'?)");
  EXPECT_EQ(ErrorOf({"a.json", "--colour"}), "no option '--colour' (see --help)");
  EXPECT_EQ(ErrorOf({"a.json", "-x"}), "no option '-x' (see --help)");
  EXPECT_EQ(ErrorOf({"a.json", "--on-loss", "contine"}),
            "command line: --on-loss: found 'contine', expected wait or continue (did you mean "
            "'continue'?)");
}

TEST(Options, HelpShowsUsagePurposeAndEveryOption) {
  const std::string help = HelpOf("--help");
  EXPECT_EQ(help.substr(0, help.find("\n  -o")),
            "Usage: muster try [OPTION...] SCENARIO\n\nTries.\n");
  for (const char* text : {"-o, --out FILE", "--share P", "(default: 0.25)", "-q, --quiet",
                           "-v, --version", "-h, --help"}) {
    EXPECT_NE(help.find(text), std::string::npos) << text << " in\n" << help;
  }
  EXPECT_EQ(help.find("scenario arg"), std::string::npos);
  EXPECT_EQ(HelpOf("-h"), help);
  EXPECT_EQ(HelpOf("-v"), HelpOf("--version"));
  EXPECT_EQ(HelpOf("-v").rfind("muster try ", 0), 0u);
}

}  // namespace
}  // namespace muster

#include "base/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cxxopts.hpp>

#include "base/check.h"
#include "base/text.h"

namespace muster {
namespace {

constexpr std::string_view kCommandLine = "command line";
/// The group of what --help shows in the usage line only.
constexpr const char* kUnlisted = "unlisted";

std::optional<std::uint64_t> ToSeed(std::string_view text) {
  std::uint64_t seed = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, seed);
  if (error != std::errc() || end != last) return std::nullopt;
  return seed;
}

bool Contains(const NumberRange& range, double value) {
  return (range.low_open ? value > range.low : value >= range.low) &&
         (range.high_open ? value < range.high : value <= range.high);
}

std::string TextOf(const NumberRange& range) {
  if (std::isinf(range.low)) return "a number";
  if (std::isinf(range.high)) {
    return fmt::format("a number {} {}", range.low_open ? "above" : "from", range.low);
  }
  if (range.low_open && !range.high_open) {
    return fmt::format("a number above {} and at most {}", range.low, range.high);
  }
  return fmt::format("a number in {}{}, {}{}", range.low_open ? '(' : '[', range.low, range.high,
                     range.high_open ? ')' : ']');
}

template <class T>
T Converted(const std::string& text) {
  if constexpr (std::is_same_v<T, std::string>) {
    return text;
  } else if constexpr (std::is_same_v<T, double>) {
    return ToNumber(text).value();
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return ToSeed(text).value();
  } else {
    return static_cast<T>(
        ToInteger(text, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()).value());
  }
}

}  // namespace

Option& Option::Default(std::string_view text) {
  default_ = text;
  return *this;
}

Option& Option::Default(double number) { return Default(fmt::format("{}", number)); }

Option& Option::Implied(std::string_view text) {
  implied_ = text;
  return *this;
}

Option& Option::Required(std::string_view expected) {
  required_ = expected;
  return *this;
}

Option& Option::List() {
  list_ = true;
  return Repeated();
}

Option& Option::Repeated() {
  repeated_ = true;
  return *this;
}

Option& Option::OneOf(std::vector<std::string> words) {
  takes_ = Takes::kWord;
  words_ = std::move(words);
  return *this;
}

Option& Option::Number(NumberRange range) {
  takes_ = Takes::kNumber;
  number_ = range;
  return *this;
}

Option& Option::Integer(std::int64_t low, std::int64_t high) {
  takes_ = Takes::kInteger;
  low_ = low;
  high_ = high;
  return *this;
}

Option& Option::Seed() {
  takes_ = Takes::kSeed;
  return *this;
}

Option& Option::Or(std::string_view word) {
  words_.emplace_back(word);
  return *this;
}

std::string Option::Expected() const {
  std::string expected = fmt::format("{}", fmt::join(words_, ", "));
  if (const std::size_t comma = expected.rfind(", "); comma != expected.npos) {
    expected.replace(comma, 2, " or ");
  }
  if (takes_ == Takes::kWord) return expected;
  if (!expected.empty()) expected += " or ";
  switch (takes_) {
    case Takes::kNumber:
      return expected + TextOf(number_);
    case Takes::kInteger:
      return expected + (high_ == std::numeric_limits<std::int64_t>::max()
                             ? fmt::format("an integer from {}", low_)
                             : fmt::format("an integer in [{}, {}]", low_, high_));
    case Takes::kSeed:
      return expected + "an integer in [0, 18446744073709551615]";
    case Takes::kNothing:
      return "no value";
    default:
      return required_.empty() ? metavar_ : required_;
  }
}

bool Option::Fits(std::string_view value) const {
  if (std::find(words_.begin(), words_.end(), value) != words_.end()) return true;
  switch (takes_) {
    case Takes::kNothing:
      return value == "true";  // what the parser gives it
    case Takes::kText:
      return !value.empty();
    case Takes::kWord:
      return false;
    case Takes::kNumber: {
      const auto number = ToNumber(value);
      return number && Contains(number_, *number);
    }
    case Takes::kInteger:
      return ToInteger(value, low_, high_).has_value();
    case Takes::kSeed:
      return ToSeed(value).has_value();
  }
  return false;
}

void Option::Check(std::string_view value) const {
  if (Fits(value)) return;
  throw InputError(kCommandLine, shown_, fmt::format("'{}'", value),
                   Expected() + DidYouMean(value, words_));
}

bool Arguments::Has(std::string_view name) const { return !EntryOf(name).values.empty(); }

const Arguments::Entry& Arguments::EntryOf(std::string_view name) const {
  const auto entry = entries_.find(name);
  MUSTER_CHECK(entry != entries_.end(), "no option {}", name);
  return entry->second;
}

template <class T>
T Arguments::Get(std::string_view name) const {
  const Entry& entry = EntryOf(name);
  MUSTER_CHECK(!entry.values.empty() || entry.option.default_, "option {} has no value", name);
  return Converted<T>(entry.values.empty() ? *entry.option.default_ : entry.values.back());
}

template <class T>
std::vector<T> Arguments::All(std::string_view name) const {
  const Entry& entry = EntryOf(name);
  std::vector<std::string> texts = entry.values;
  if (texts.empty() && entry.option.default_) texts = Split(*entry.option.default_, ',');
  std::vector<T> values;
  for (const std::string& text : texts) values.push_back(Converted<T>(text));
  return values;
}

template std::string Arguments::Get(std::string_view) const;
template double Arguments::Get(std::string_view) const;
template int Arguments::Get(std::string_view) const;
template std::int64_t Arguments::Get(std::string_view) const;
template std::uint64_t Arguments::Get(std::string_view) const;
template std::vector<std::string> Arguments::All(std::string_view) const;
template std::vector<double> Arguments::All(std::string_view) const;

Options::Options(std::string_view program, std::string_view purpose)
    : program_(program), purpose_(purpose) {}

void Options::Group(std::string_view name) { group_ = name; }

Option& Options::Add(std::string_view names, std::string_view metavar, std::string_view help) {
  Option& option = options_.emplace_back();
  option.names_ = names;
  option.name_ = names.substr(names.find(',') + 1);  // npos + 1 is 0
  option.shown_ = "--" + option.name_;
  option.metavar_ = metavar;
  option.help_ = help;
  option.group_ = group_;
  return option;
}

void Options::Flag(std::string_view names, std::string_view help) {
  Add(names, "", help).takes_ = Option::Takes::kNothing;
}

Option& Options::Positional(std::string_view name, std::string_view usage) {
  Option& option = Add(name, usage, "");
  option.shown_ = usage.substr(0, usage.find(' '));
  option.group_ = kUnlisted;
  option.positional_ = true;
  return option;
}

void Options::RestBelongsTo(std::string_view name) { rest_ = name; }

Option& Options::Scenario() {
  return Positional("scenario", "SCENARIO").Required("a scenario file");
}

Option& Options::Run() {
  return Positional("run", "RUN").Required("a run directory or a log file");
}

Option& Options::Out(std::string_view metavar, std::string_view help) {
  return Add("o,out", metavar, help);
}

void Options::Json() { Flag("json", "Print the result as JSON"); }

void Options::Quiet() { Flag("q,quiet", "No progress on stderr, only errors"); }

namespace {

void RefuseUnmatched(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& known) {
  for (const std::string& argument : arguments) {
    if (argument.size() < 2 || argument[0] != '-') continue;
    const std::string name = argument.substr(0, argument.find('='));
    const std::string near = DidYouMean(name, known);
    throw InputError(fmt::format("no option '{}'{}", name, near.empty() ? " (see --help)" : near));
  }
  if (arguments.empty()) return;
  throw InputError(fmt::format("unexpected argument '{}' (see --help)", arguments.front()));
}

}  // namespace

std::optional<Arguments> Options::Parse(int argc, const char* const* argv) {
  Group("");
  Flag("h,help", "Print this help and exit");
  Flag("v,version", "Print the version and exit");

  cxxopts::Options parser(program_);
  parser.set_width(80)
      .custom_help("")
      .positional_help("")
      .show_positional_help()
      .allow_unrecognised_options();
  std::string usage = fmt::format("Usage: {} [OPTION...]", program_);
  std::vector<std::string> positionals;
  std::vector<std::string> groups = {""};
  std::vector<std::string> known;
  for (const Option& option : options_) {
    std::shared_ptr<cxxopts::Value> value;
    if (option.takes_ == Option::Takes::kNothing) {
      value = cxxopts::value<bool>();
    } else if (option.repeated_) {
      value = cxxopts::value<std::vector<std::string>>();
    } else {
      value = cxxopts::value<std::string>();
    }
    if (option.default_) value->default_value(*option.default_);
    if (option.implied_) value->implicit_value(*option.implied_);
    parser.add_options(option.group_)(option.names_, option.help_, value, option.metavar_);
    if (option.positional_) {
      positionals.push_back(option.name_);
      usage += " " + option.metavar_;
      continue;
    }
    known.push_back(option.shown_);
    if (std::find(groups.begin(), groups.end(), option.group_) == groups.end()) {
      groups.push_back(option.group_);
    }
  }
  if (!rest_.empty()) positionals.push_back(rest_);
  parser.parse_positional(positionals);

  cxxopts::ParseResult parsed;
  try {
    parsed = parser.parse(argc, argv);
  } catch (const cxxopts::exceptions::exception& error) {
    throw InputError(fmt::format("{} (see --help)", error.what()));
  }
  if (parsed.count("help") > 0) {
    fmt::print("{}\n\n{}{}", usage, purpose_, parser.help(groups, false));
    return std::nullopt;
  }
  if (parsed.count("version") > 0) {
    fmt::print("{} {}\n", program_, MUSTER_VERSION);
    return std::nullopt;
  }
  RefuseUnmatched(parsed.unmatched(), known);

  Arguments arguments;
  for (const Option& option : options_) arguments.entries_[option.name_].option = option;
  for (const cxxopts::KeyValue& given : parsed.arguments()) {
    auto& [option, values] = arguments.entries_[given.key()];
    std::vector<std::string> texts = {given.value()};
    if (option.list_) texts = Split(given.value(), ',');
    for (std::string& text : texts) {
      option.Check(text);
      values.push_back(std::move(text));
    }
  }
  for (const Option& option : options_) {
    if (!option.required_.empty() && !arguments.Has(option.name_)) {
      throw InputError(kCommandLine, option.shown_, "nothing", option.required_);
    }
  }
  return arguments;
}

}  // namespace muster

#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace muster {

/// The numbers that an option takes.
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< `low` itself is none of them
  bool high_open = false;
};

/// Numbers above 0, up to `high`.
constexpr NumberRange Above0(double high = std::numeric_limits<double>::infinity()) {
  return {0, high, true, false};
}

/// What a program's option takes. One that says nothing takes any text but an empty one.
class Option {
 public:
  Option& Default(std::string_view text);
  Option& Default(double number);
  /// What it means to give the option without a value.
  Option& Implied(std::string_view text);
  /// It must be given; `expected` says what is missing when it is not.
  Option& Required(std::string_view expected);
  /// Takes several values: between commas, or by being given again.
  Option& List();
  /// May be given again; commas are part of a value.
  Option& Repeated();
  Option& OneOf(std::vector<std::string> words);
  Option& Number(NumberRange range = {});
  Option& Integer(std::int64_t low, std::int64_t high = std::numeric_limits<std::int64_t>::max());
  /// A seed: any integer of 64 bits without a sign.
  Option& Seed();
  /// This word too, beside the numbers.
  Option& Or(std::string_view word);

 private:
  friend class Options;
  friend class Arguments;
  enum class Takes { kNothing, kText, kWord, kNumber, kInteger, kSeed };

  [[nodiscard]] std::string Expected() const;
  [[nodiscard]] bool Fits(std::string_view value) const;
  /// Throws InputError naming the option, the value and what was expected.
  void Check(std::string_view value) const;

  std::string names_;  // "q,quiet"
  std::string name_;   // "quiet"
  std::string shown_;  // "--quiet", "SCENARIO"
  std::string metavar_;
  std::string help_;
  std::string group_;
  bool positional_ = false;
  Takes takes_ = Takes::kText;
  bool list_ = false;
  bool repeated_ = false;
  std::optional<std::string> default_;
  std::optional<std::string> implied_;
  std::string required_;
  std::vector<std::string> words_;
  NumberRange number_;
  std::int64_t low_ = 0;
  std::int64_t high_ = 0;
};

/// What a command line said, checked against its options. Asking for an option that was not
/// declared, or for a value that is not of its kind, is a broken invariant.
class Arguments {
 public:
  /// Was it given?
  [[nodiscard]] bool Has(std::string_view name) const;

  /// The value given last, or the default. T: std::string, double, int, std::int64_t,
  /// std::uint64_t.
  template <class T = std::string>
  [[nodiscard]] T Get(std::string_view name) const;

  /// All values, or those of the default; none where there is neither.
  template <class T = std::string>
  [[nodiscard]] std::vector<T> All(std::string_view name) const;

  /// Puts the value there when the option was given.
  template <class T>
  void Read(std::string_view name, T* to) const {
    if (Has(name)) *to = Get<T>(name);
  }
  template <class T>
  void Read(std::string_view name, std::optional<T>* to) const {
    if (Has(name)) *to = Get<T>(name);
  }

 private:
  friend class Options;
  struct Entry {
    Option option;
    std::vector<std::string> values;  // empty: not given
  };
  [[nodiscard]] const Entry& EntryOf(std::string_view name) const;

  std::map<std::string, Entry, std::less<>> entries_;
};

/// The options of one program. Every program of ours declares them here and nowhere else.
class Options {
 public:
  /// `program` as the user calls it, "muster run"; `purpose`: what it does, for --help.
  Options(std::string_view program, std::string_view purpose);

  /// What is added from here on stands in --help below "NAME options:".
  void Group(std::string_view name);
  /// An option with a value. `names`: "out", or "o,out" with a short one.
  Option& Add(std::string_view names, std::string_view metavar, std::string_view help);
  /// One without.
  void Flag(std::string_view names, std::string_view help);
  /// An argument without an option's name, in their order; `usage` as --help shows it, "RUN".
  Option& Positional(std::string_view name, std::string_view usage);
  /// Arguments without a name are further values of that option, which takes several.
  void RestBelongsTo(std::string_view name);

  // What several programs share has the same name and meaning in each.
  Option& Scenario();
  /// A run directory or log file.
  Option& Run();
  Option& Out(std::string_view metavar, std::string_view help);
  void Json();
  void Quiet();

  /// Reads a command line. No value: --help or --version was answered, the program exits with 0.
  /// Throws InputError.
  std::optional<Arguments> Parse(int argc, const char* const* argv);

 private:
  std::string program_;
  std::string purpose_;
  std::string group_;
  std::string rest_;
  std::deque<Option> options_;
};

}  // namespace muster

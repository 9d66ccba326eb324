#include "tools/replay/replay_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "base/check.h"
#include "base/program.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/multicast.h"
#include "lcmtypes/channels.h"
#include "protocol/run_process.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/log/log_source.h"
#include "tools/replay/player.h"
#include "tools/replay/terminal_keys.h"

namespace muster::tools {
namespace {

constexpr TimeUs kLongestWaitUs = 100'000;

double ParseRate(const std::string& text) {
  if (text == "max") return 0;
  std::size_t end = 0;
  double rate = 0;
  try {
    rate = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  if (end != text.size() || !(rate > 0) || !std::isfinite(rate)) {
    throw InputError("command line", "--rate", text, "a number above 0 or max");
  }
  return rate;
}

std::regex ParseRegex(const std::string& flag, const std::string& text) {
  try {
    return std::regex(text);
  } catch (const std::regex_error&) {
    throw InputError("command line", flag, text, "a regular expression");
  }
}

PlayerOptions ReadPlayerOptions(const cxxopts::ParseResult& parsed) {
  PlayerOptions options;
  options.rate = ParseRate(parsed["rate"].as<std::string>());
  const double offset_s = parsed["start-offset"].as<double>();
  if (!(offset_s >= 0) || offset_s > 1e9) {
    throw InputError("command line", "--start-offset", fmt::format("{}", offset_s),
                     "seconds, at least 0");
  }
  options.start_offset_us = ToUs(offset_s);
  options.paused = parsed.count("start-paused") > 0;
  options.loop = parsed.count("loop") > 0;
  const std::regex only = ParseRegex("--channels", parsed["channels"].as<std::string>());
  const std::regex without = ParseRegex("--without", parsed["without"].as<std::string>());
  const bool some_left_out = parsed.count("without") > 0;
  options.plays = [=](const std::string& channel) {
    // The bus carries our channels only; LCM's own self test is in every log.
    return FindChannel(channel) != nullptr && std::regex_match(channel, only) &&
           !(some_left_out && std::regex_match(channel, without));
  };
  return options;
}

std::string StatusLine(const Player& player, TimeUs now_us) {
  const std::string rate =
      player.rate() == 0 ? "as fast as it goes" : fmt::format("{:g}x", player.rate());
  return fmt::format("{}  {}  decision {}  {} messages  next message in {:.1f} s",
                     ClockText(player.position_us(now_us)), player.paused() ? "paused" : rate,
                     player.decision(), player.played(), ToSeconds(player.ToNextUs(now_us)));
}

}  // namespace

int ReplayCommand(int argc, const char* const* argv) {
  cxxopts::Options options(
      argv[0],
      "Plays a run's log back over LCM, byte for byte, paced by mission time.\n"
      "Keys: space pauses, right arrow steps to the next decision, up and down change the rate, q "
      "ends.");
  options.add_options()("run", "Run directory or log file", cxxopts::value<std::string>())(
      "rate", "Mission seconds per second, or max",
      cxxopts::value<std::string>()->default_value("60"),
      "R")("start-offset", "Mission time to start at, seconds; the scenario is sent all the same",
           cxxopts::value<double>()->default_value("0"),
           "S")("start-paused", "Wait for a key")("loop", "Start over at the end")(
      "channels", "Play only channels that match this regular expression as a whole",
      cxxopts::value<std::string>()->default_value(".*"),
      "REGEX")("without", "Leave out channels that match, say MUSTER_SCHEDULE",
               cxxopts::value<std::string>()->default_value(""), "REGEX")(
      "l,lcm-url", "LCM URL", cxxopts::value<std::string>()->default_value(DefaultUrl()), "URL")(
      "q,quiet", "No progress on stderr, only errors");
  options.parse_positional({"run"});
  options.positional_help("RUN");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  if (parsed->count("run") == 0) throw InputError("no RUN given: a run directory or a log file");
  const PlayerOptions player_options = ReadPlayerOptions(*parsed);
  LogSource source((*parsed)["run"].as<std::string>());
  const bool quiet = parsed->count("quiet") > 0;

  LcmBus bus((*parsed)["lcm-url"].as<std::string>());
  Player player(&source, player_options);
  TerminalKeys keys;
  if (player_options.paused && !keys.usable()) {
    throw InputError("command line", "--start-paused", "no terminal on stdin",
                     "a terminal, whose space key goes on");
  }
  const StopSignals stop;
  ProgressPrinter progress(stderr, StyleFor(stderr, quiet));
  bool quit = false;
  while (!player.ended() && !quit && stop.count() == 0) {
    const TimeUs now = MonotonicUs();
    for (const Packet& packet : player.Step(now)) bus.Publish(packet);
    bus.Receive(0);  // what it hears of itself
    if (progress.due(now)) progress.Show(StatusLine(player, now), now);
    if (player.ended()) break;
    const TimeUs wait = std::min(player.WakeUs(now) - now, kLongestWaitUs);
    const Pressed pressed = keys.Wait(std::max<TimeUs>(0, wait));
    for (const Player::Key key : pressed.keys) player.Press(key, MonotonicUs());
    quit = pressed.quit;
  }
  progress.Break();
  if (!quiet) fmt::print(stderr, "played {} messages\n", player.played());
  return stop.count() > 0 ? kExitInterrupted : kExitOk;
}

}  // namespace muster::tools

#include "tools/replay/replay_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
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

std::regex ParseRegex(const std::string& flag, const std::string& text) {
  try {
    return std::regex(text);
  } catch (const std::regex_error&) {
    throw InputError("command line", flag, text, "a regular expression");
  }
}

PlayerOptions ReadPlayerOptions(const Arguments& arguments) {
  PlayerOptions options;
  options.rate = arguments.Get("rate") == "max" ? 0 : arguments.Get<double>("rate");
  options.start_offset_us = ToUs(arguments.Get<double>("start-offset"));
  options.paused = arguments.Has("start-paused");
  options.loop = arguments.Has("loop");
  const std::regex only = ParseRegex("--channels", arguments.Get("channels"));
  const bool some_left_out = arguments.Has("without");
  const std::regex without = ParseRegex("--without", some_left_out ? arguments.Get("without") : "");
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
  Options options(
      argv[0],
      "Plays a run's log back over LCM, byte for byte, paced by mission time.\n"
      "Keys: space pauses, right arrow steps to the next decision, up and down change the rate, q "
      "ends.");
  options.Run();
  options.Add("rate", "R", "Mission seconds per second, or max")
      .Number({.low = 1e-3})
      .Or("max")
      .Default(60);
  options
      .Add("start-offset", "S",
           "Mission time to start at, seconds; the scenario is sent all the same")
      .Number({0, 1e9})
      .Default(0);
  options.Flag("start-paused", "Wait for a key");
  options.Flag("loop", "Start over at the end");
  options
      .Add("channels", "REGEX", "Play only channels that match this regular expression as a whole")
      .Default(".*");
  options.Add("without", "REGEX", "Leave out channels that match, say MUSTER_SCHEDULE");
  options.Add("l,lcm-url", "URL", "LCM URL").Default(DefaultUrl());
  options.Quiet();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const PlayerOptions player_options = ReadPlayerOptions(*arguments);
  LogSource source(arguments->Get("run"));
  const bool quiet = arguments->Has("quiet");

  LcmBus bus(arguments->Get("lcm-url"), kMostTagBytes);
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
  if (!quiet) Say("played {} messages\n", player.played());
  return stop.count() > 0 ? kExitInterrupted : kExitOk;
}

}  // namespace muster::tools

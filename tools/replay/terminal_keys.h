#pragma once

#include <termios.h>
#include <string>
#include <vector>

#include "tools/replay/player.h"

namespace muster::tools {

/// What a user pressed: a key of the player, or the wish to end.
struct Pressed {
  std::vector<Player::Key> keys;
  bool quit = false;
};

/// Reads the bytes of a terminal: space pauses, right arrow steps to the next decision, up and down
/// change the rate, q ends. Escape sequences may come in pieces.
class KeyParser {
 public:
  Pressed Take(const std::string& bytes);

 private:
  std::string escape_;  ///< of a sequence that has begun
};

/// The terminal on stdin, without echo and line by line reading while this exists; nothing when
/// stdin is no terminal.
class TerminalKeys {
 public:
  TerminalKeys();
  ~TerminalKeys();
  TerminalKeys(const TerminalKeys&) = delete;
  TerminalKeys& operator=(const TerminalKeys&) = delete;

  bool usable() const { return usable_; }
  /// Waits at most `timeout_us` for keys.
  Pressed Wait(TimeUs timeout_us);

 private:
  bool usable_ = false;
  termios before_ = {};
  KeyParser parser_;
};

}  // namespace muster::tools

#include "tools/replay/terminal_keys.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>

namespace muster::tools {

Pressed KeyParser::Take(const std::string& bytes) {
  Pressed pressed;
  for (const char c : bytes) {
    if (escape_.empty()) {
      if (c == '\x1b') escape_ = c;
      if (c == ' ') pressed.keys.push_back(Player::Key::kPause);
      if (c == 'q' || c == 'Q') pressed.quit = true;
      continue;
    }
    // "ESC [ C" in normal, "ESC O C" in application mode.
    escape_ += c;
    if (escape_.size() == 2 && (c == '[' || c == 'O')) continue;
    if (escape_.size() == 3) {
      if (c == 'A') pressed.keys.push_back(Player::Key::kFaster);
      if (c == 'B') pressed.keys.push_back(Player::Key::kSlower);
      if (c == 'C') pressed.keys.push_back(Player::Key::kNextDecision);
    }
    escape_.clear();
  }
  return pressed;
}

TerminalKeys::TerminalKeys() {
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &before_) != 0) return;
  // A background job that touches its terminal would be stopped.
  if (tcgetpgrp(STDIN_FILENO) != getpgrp()) return;
  termios raw = before_;
  raw.c_lflag &= static_cast<tcflag_t>(~(ICANON | ECHO));
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  usable_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

TerminalKeys::~TerminalKeys() {
  if (usable_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

Pressed TerminalKeys::Wait(TimeUs timeout_us) {
  const timespec timeout = {timeout_us / kSecondUs, timeout_us % kSecondUs * 1000};
  pollfd input = {STDIN_FILENO, POLLIN, 0};
  if (ppoll(&input, usable_ ? 1 : 0, &timeout, nullptr) <= 0) return {};
  char bytes[64];
  const ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
  if (n <= 0) {
    usable_ = usable_ && n < 0;  // hung up: go on without keys
    return {};
  }
  return parser_.Take(std::string(bytes, static_cast<std::size_t>(n)));
}

}  // namespace muster::tools

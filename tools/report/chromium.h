#pragma once

#include <sys/types.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace muster::tools {

/// A Chromium without a window that shows one page, told what to do over the pipe of its DevTools
/// protocol. It ends with this object.
class Chromium {
 public:
  /// Shows a page, `page_url`, in a window of so many pixels; what it writes goes into `folder`.
  /// Throws SystemError when there is no Chromium in PATH or it does not start.
  Chromium(const std::string& page_url, const std::string& folder, int width, int height);
  ~Chromium();
  Chromium(const Chromium&) = delete;
  Chromium& operator=(const Chromium&) = delete;

  /// The text that an expression of the page's script gives, its promise kept; "" for none. Throws
  /// SystemError with what the script threw, or when nothing is said for two minutes.
  std::string Evaluate(std::string_view expression);

 private:
  nlohmann::ordered_json Call(std::string_view method, const nlohmann::ordered_json& parameters);
  void Send(const std::string& message);
  std::string Receive();
  void End();

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;  // ours of the two pipes
  int next_id_ = 0;
  std::string session_;   // of the page
  std::string received_;  // the beginning of the next message
};

}  // namespace muster::tools

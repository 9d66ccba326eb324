#include "tools/report/chromium.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "base/check.h"

extern char** environ;

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

constexpr int kSilenceMs = 120'000;
constexpr int kEndMs = 3'000;
constexpr int kRead = 3, kWrite = 4;  ///< Chromium's ends, --remote-debugging-pipe
constexpr int kAboveThose = 10;

std::optional<std::string> FindChromium() {
  const char* path = std::getenv("PATH");
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      std::string file = folder + "/" + name;
      if (!folder.empty() && access(file.c_str(), X_OK) == 0) return file;
    }
  }
  return std::nullopt;
}

[[noreturn]] void Fail(const std::string& why) {
  throw SystemError("Chromium, which draws the scene: " + why);
}

/// Two ends of a pipe, both closed by exec and with numbers above those that Chromium takes.
struct Pipe {
  Pipe() {
    int low[2];
    if (pipe2(low, O_CLOEXEC) != 0) Fail(std::strerror(errno));
    for (int i = 0; i < 2; ++i) {
      ends[i] = fcntl(low[i], F_DUPFD_CLOEXEC, kAboveThose);
      close(low[i]);
    }
    if (ends[0] < 0 || ends[1] < 0) Fail(std::strerror(EMFILE));
  }
  int ends[2];
};

}  // namespace

Chromium::Chromium(const std::string& page_url, const std::string& folder, int width, int height) {
  const auto program = FindChromium();
  if (!program) {
    throw SystemError(
        "pictures of the scene need Chromium, and there is none in PATH (Debian: apt-get install "
        "chromium)");
  }
  std::vector<std::string> arguments = {
      *program, "--headless", "--remote-debugging-pipe", "--no-first-run", "--disable-extensions",
      "--hide-scrollbars", "--force-device-scale-factor=1",
      // WebGL without a graphics card: the same picture on every machine.
      "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
      fmt::format("--window-size={},{}", width, height), "--user-data-dir=" + folder + "/profile"};
  // The sandbox wants namespaces, which root in a container has not. The page is our own.
  if (geteuid() == 0) arguments.emplace_back("--no-sandbox");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const Pipe to, from;
  const std::string log = folder + "/chromium.log";
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  posix_spawn_file_actions_adddup2(&files, to.ends[0], kRead);
  posix_spawn_file_actions_adddup2(&files, from.ends[1], kWrite);
  posix_spawnattr_t attributes;  // a group of its own: all of it can be ended
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawn(&pid_, program->c_str(), &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  close(to.ends[0]);
  close(from.ends[1]);
  to_ = to.ends[1];
  from_ = from.ends[0];
  if (error != 0) pid_ = -1;
  try {
    if (error != 0) Fail(fmt::format("cannot start {}: {}", *program, std::strerror(error)));
    const auto target = Call("Target.createTarget", {{"url", "about:blank"}});
    const auto session =
        Call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}});
    session_ = session.at("sessionId").get<std::string>();
    // The window has a frame, the page has not.
    Call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    // Answered once the page has taken the place of the blank one, with its own scripts.
    const auto page = Call("Page.navigate", {{"url", page_url}});
    if (page.contains("errorText")) Fail(page["errorText"].get<std::string>());
  } catch (...) {
    End();
    throw;
  }
}

Chromium::~Chromium() { End(); }

void Chromium::End() {
  // It ends when its pipe does.
  close(to_);
  close(from_);
  if (pid_ < 0) return;
  for (int waited_ms = 0; waitpid(pid_, nullptr, WNOHANG) == 0; waited_ms += 20) {
    if (waited_ms >= kEndMs) kill(-pid_, SIGKILL);
    poll(nullptr, 0, 20);
  }
  pid_ = -1;
}

void Chromium::Send(const std::string& message) {
  const std::string text = message + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = write(to_, text.data() + sent, text.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) Fail("it has ended");
    sent += static_cast<std::size_t>(n);
  }
}

std::string Chromium::Receive() {
  std::size_t searched = 0;
  while (true) {
    const std::size_t end = received_.find('\0', searched);
    if (end != std::string::npos) {
      std::string message = received_.substr(0, end);
      received_.erase(0, end + 1);
      return message;
    }
    searched = received_.size();
    pollfd readable = {from_, POLLIN, 0};
    const int ready = poll(&readable, 1, kSilenceMs);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) Fail(fmt::format("it has said nothing for {} s", kSilenceMs / 1000));
    char buffer[1 << 16];
    const ssize_t n = read(from_, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) Fail("it has ended");
    received_.append(buffer, static_cast<std::size_t>(n));
  }
}

ordered_json Chromium::Call(std::string_view method, const ordered_json& parameters) {
  const int id = ++next_id_;
  ordered_json message = {{"id", id}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  Send(message.dump());
  while (true) {
    const ordered_json answer = ordered_json::parse(Receive(), nullptr, false);
    if (!answer.is_object() || answer.value("id", 0) != id) continue;  // an event
    if (answer.contains("error")) Fail(answer["error"].value("message", std::string(method)));
    return answer.value("result", ordered_json::object());
  }
}

std::string Chromium::Evaluate(std::string_view expression) {
  const ordered_json result =
      Call("Runtime.evaluate",
           {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (const auto thrown = result.find("exceptionDetails"); thrown != result.end()) {
    const auto exception = thrown->value("exception", ordered_json::object());
    Fail(exception.value("description", thrown->value("text", "a script failed")));
  }
  const auto value = result.at("result").value("value", ordered_json());
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
}

}  // namespace muster::tools

#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

namespace muster::tools {

/// A new folder for one test, removed with all that it holds.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string File(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Looks again and again until `holds()` or a minute is over; returns what it held last.
template <class Condition>
bool Eventually(Condition holds) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!holds()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// The file's text; "" when it cannot be read.
std::string TextOf(const std::string& file);

}  // namespace muster::tools

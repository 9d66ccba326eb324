#include "tools/launch/hosts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <map>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text.h"
#include "base/text_file.h"
#include "lcmtypes/bus/multicast.h"
#include "protocol/fault_kinds.h"

namespace muster::tools {
namespace {

/// An object of the file, its keys taken one by one.
class Object {
 public:
  Object(const JsonValue& value, std::string file, std::string at)
      : value_(value), file_(std::move(file)), at_(std::move(at)) {
    if (value.type != JsonValue::Type::kObject) Refuse("", value.Shown(), "an object");
  }

  std::string Text(std::string_view key, bool needed) {
    const JsonValue* value = Take(key, needed);
    if (value == nullptr) return "";
    if (value->type != JsonValue::Type::kString || value->text.empty()) {
      Refuse(key, value->Shown(), "a text");
    }
    // Neither may be taken for an option of ssh or ip.
    if (value->text.front() == '-') Refuse(key, value->text, "a text that does not begin with -");
    return value->text;
  }
  /// A number above 0; 0 where the key is not there.
  double Positive(std::string_view key) {
    const JsonValue* value = Take(key, false);
    if (value == nullptr) return 0;
    const double number =
        value->type == JsonValue::Type::kNumber ? ToNumber(value->text).value_or(0) : 0;
    if (!(number > 0) || std::isinf(number)) Refuse(key, value->Shown(), "a number above 0");
    return number;
  }
  const std::vector<JsonValue>& List(std::string_view key) {
    const JsonValue* value = Take(key, true);
    if (value->type != JsonValue::Type::kArray || value->items.empty()) {
      Refuse(key, value->Shown(), "a list that is not empty");
    }
    return value->items;
  }
  void ExpectVersion() {
    const JsonValue* value = Take("version", true);
    if (value->type != JsonValue::Type::kNumber || value->text != "1") {
      Refuse("version", value->Shown(), "1");
    }
  }
  void ExpectNoMore() const {
    for (const JsonValue::Member& member : value_.members) {
      if (std::find(taken_.begin(), taken_.end(), member.name) == taken_.end()) {
        Refuse(member.name, "it", fmt::format("one of {}", fmt::join(taken_, ", ")));
      }
    }
  }
  [[noreturn]] void Refuse(std::string_view key, const std::string& found,
                           const std::string& expected) const {
    throw InputError(file_, at_ + std::string(key), found, expected);
  }

 private:
  const JsonValue* Take(std::string_view key, bool needed) {
    taken_.emplace_back(key);
    const JsonValue* value = value_.Find(key);
    if (value == nullptr && needed) Refuse(key, "nothing", "a value");
    return value;
  }

  const JsonValue& value_;
  std::string file_;
  std::string at_;
  std::vector<std::string> taken_;
};

Host ReadHost(const JsonValue& json, const std::string& file, std::size_t i) {
  Object object(json, file, fmt::format("hosts[{}].", i));
  Host host;
  host.name = object.Text("name", true);
  host.ssh = object.Text("ssh", false);
  host.netns = object.Text("netns", false);
  host.folder = object.Text("folder", false);
  for (const JsonValue& process : object.List("processes")) {
    if (process.type != JsonValue::Type::kString) {
      object.Refuse("processes", process.Shown(), "names of processes, such as uav or scheduler");
    }
    host.processes.push_back(process.text);
  }
  host.mbit_s = object.Positive("mbit_s");
  object.ExpectNoMore();
  if (host.ssh.empty() == host.netns.empty()) {
    object.Refuse("ssh", host.ssh.empty() ? "neither ssh nor netns" : "ssh and netns",
                  "one of the two");
  }
  return host;
}

/// The text as one word of a POSIX shell.
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace

const Host* HostList::Of(std::string_view process) const {
  for (const Host& host : hosts) {
    if (std::find(host.processes.begin(), host.processes.end(), process) != host.processes.end()) {
      return &host;
    }
  }
  return nullptr;
}

HostList ParseHosts(std::string_view json, const std::string& file) {
  const JsonValue value = ParseJson(json, file);
  Object object(value, file, "");
  object.ExpectVersion();
  HostList list;
  list.lcm_url = object.Text("lcm_url", false);
  if (list.lcm_url.empty()) list.lcm_url = MissionUrl(7667, 1);
  const MulticastUrl url = ParseMulticastUrl(list.lcm_url, file + ": lcm_url");
  if (url.ttl < 1) {
    object.Refuse("lcm_url", list.lcm_url, "a URL with ttl=1 or more: ttl=0 leaves no host");
  }
  const std::vector<JsonValue>& hosts = object.List("hosts");
  for (std::size_t i = 0; i < hosts.size(); ++i) list.hosts.push_back(ReadHost(hosts[i], file, i));
  object.ExpectNoMore();
  return list;
}

HostList LoadHosts(const std::string& file) {
  return ParseHosts(ReadTextFile(file, "a list of hosts"), file);
}

void CheckHosts(const HostList& list, const std::string& file,
                const std::vector<std::string>& processes, const FaultPlan& faults) {
  std::map<std::string, std::string> host_of;
  for (const Host& host : list.hosts) {
    for (const std::string& process : host.processes) {
      const std::string key = fmt::format("host {}: processes", host.name);
      if (std::find(processes.begin(), processes.end(), process) == processes.end()) {
        throw InputError(file, key, process,
                         fmt::format("processes of the mission: {}", fmt::join(processes, ", ")));
      }
      const auto [other, added] = host_of.emplace(process, host.name);
      if (!added) {
        throw InputError(file, key, process,
                         fmt::format("a process on one host: it is on {}, too", other->second));
      }
    }
  }
  for (const PlannedFault& fault : faults) {
    const Host* host = list.Of(fault.target);
    if (RowOf(fault.kind).begin_signal == SIGSTOP && host != nullptr && !host->ssh.empty()) {
      throw InputError(fault.where, "target", fault.target,
                       "a process that ssh does not stand before: it cannot be stopped from here");
    }
  }
}

ChildSpec OnHost(const Host& host, ChildSpec spec) {
  if (!host.folder.empty()) {
    const std::filesystem::path program = spec.argv.front();
    spec.argv.front() = (std::filesystem::path(host.folder) / program.filename()).string();
  }
  if (!host.netns.empty()) {
    spec.argv.insert(spec.argv.begin(), {"/usr/bin/env", "ip", "netns", "exec", host.netns});
    return spec;
  }
  std::string command;
  for (const std::string& word : spec.argv) command += Quoted(word) + " ";
  // The remote end of stdin closes when ssh ends in any way: then the program is told to stop.
  // A key comes first; the shell's own read and echo keep it out of every command line.
  const std::string start =
      spec.input.empty()
          ? fmt::format("{} </dev/null &", command)
          : fmt::format("IFS= read -r key <&3; echo \"$key\" | {} & unset key;", command);
  const std::string remote = fmt::format(
      "exec 3<&0; {} p=$!; "
      "{{ cat <&3 >/dev/null 2>&1; kill -TERM $p; }} 2>/dev/null & w=$!; "
      "wait $p; code=$?; kill $w 2>/dev/null; exit $code",
      start);
  spec.argv = {"/usr/bin/env", "ssh",
               "-o",           "BatchMode=yes",
               "-o",           "ServerAliveInterval=5",
               host.ssh,       "sh -c " + Quoted(remote)};
  spec.hold_stdin = true;
  return spec;
}

}  // namespace muster::tools

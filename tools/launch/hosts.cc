#include "tools/launch/hosts.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <map>
#include <utility>

#include "base/check.h"
#include "base/object_reader.h"
#include "base/text_file.h"
#include "lcmtypes/bus/multicast.h"
#include "protocol/fault_kinds.h"

namespace muster::tools {
namespace {

/// A text that ssh and ip do not take for an option; "" where the key is not there.
std::string Text(const ObjectReader& object, std::string_view key) {
  if (!object.Has(key)) return "";
  std::string text = object.String(key);
  if (text.empty() || text.front() == '-') {
    object.Fail(key, *object.Optional(key), "a text that does not begin with -");
  }
  return text;
}

const std::vector<JsonValue>& List(const ObjectReader& object, std::string_view key) {
  const std::vector<JsonValue>& list = object.Array(key);
  if (list.empty()) object.Fail(key, *object.Optional(key), "a list that is not empty");
  return list;
}

Host ReadHost(const ObjectReader& object) {
  object.AllowOnly({"name", "ssh", "netns", "folder", "processes", "mbit_s", "standby"});
  Host host;
  static_cast<void>(object.Required("name", "a text"));
  host.name = Text(object, "name");
  host.ssh = Text(object, "ssh");
  host.netns = Text(object, "netns");
  host.folder = Text(object, "folder");
  host.standby = Text(object, "standby");
  for (const JsonValue& process : List(object, "processes")) {
    if (process.type != JsonValue::Type::kString) {
      object.Fail("processes", process, "names of processes, such as uav or scheduler");
    }
    host.processes.push_back(process.text);
  }
  if (object.Has("mbit_s")) {
    host.mbit_s = object.Number("mbit_s");
    if (!(host.mbit_s > 0)) object.Fail("mbit_s", *object.Optional("mbit_s"), "a number above 0");
  }
  if (host.ssh.empty() == host.netns.empty()) {
    object.Fail("ssh", host.ssh.empty() ? "neither ssh nor netns" : "ssh and netns",
                "one of the two");
  }
  return host;
}

}  // namespace

std::string QuotedForShell(std::string_view word) {
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

const Host* HostList::Of(std::string_view process) const {
  for (const Host& host : hosts) {
    if (std::find(host.processes.begin(), host.processes.end(), process) != host.processes.end()) {
      return &host;
    }
  }
  return nullptr;
}

void HostList::MoveToStandby(const std::string& name) {
  const auto named = [this](const std::string& of) {
    return std::find_if(hosts.begin(), hosts.end(),
                        [&](const Host& host) { return host.name == of; });
  };
  const auto gone = named(name);
  MUSTER_CHECK(gone != hosts.end(), "{}", name);
  const auto standby = named(std::exchange(gone->standby, ""));
  std::vector<std::string> processes = std::exchange(gone->processes, {});
  if (standby == hosts.end()) return;  // here
  std::move(processes.begin(), processes.end(), std::back_inserter(standby->processes));
}

HostList ParseHosts(std::string_view json, const std::string& file) {
  const JsonValue value = ParseJson(json, file);
  const ObjectReader object(value, "", file);
  object.AllowOnly({"version", "lcm_url", "hosts"});
  object.Expect("version", 1);
  HostList list;
  list.lcm_url = Text(object, "lcm_url");
  if (list.lcm_url.empty()) list.lcm_url = MissionUrl(7667, 1);
  const MulticastUrl url = ParseMulticastUrl(list.lcm_url, file + ": lcm_url");
  if (url.ttl < 1) {
    object.Fail("lcm_url", list.lcm_url, "a URL with ttl=1 or more: ttl=0 leaves no host");
  }
  const std::vector<JsonValue>& hosts = List(object, "hosts");
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    list.hosts.push_back(ReadHost(object.Element("hosts", hosts[i], i)));
  }
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
  for (const Host& host : list.hosts) {
    const auto is_standby = [&](const Host& other) {
      return other.name == host.standby && &other != &host;
    };
    if (host.standby.empty() || host.standby == kHere ||
        std::any_of(list.hosts.begin(), list.hosts.end(), is_standby)) {
      continue;
    }
    throw InputError(file, fmt::format("host {}: standby", host.name), host.standby,
                     fmt::format("the name of another host, or {}", kHere));
  }
  for (const PlannedFault& fault : faults) {
    const Host* host = list.Of(fault.target);
    if (RowOf(fault.kind).begin_signal == SIGSTOP && host != nullptr && !host->ssh.empty()) {
      throw InputError(
          fault.where, "target", fault.target,
          "a process on a host without ssh: one behind ssh cannot be stopped from here");
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
  for (const std::string& word : spec.argv) command += QuotedForShell(word) + " ";
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
               "-o",           "ConnectTimeout=10",
               host.ssh,       "sh -c " + QuotedForShell(remote)};
  spec.hold_stdin = true;
  return spec;
}

}  // namespace muster::tools

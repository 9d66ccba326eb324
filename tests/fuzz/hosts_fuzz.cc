// Arbitrary text as a host list: refused with InputError, or every process of it has its host.

#include <string>

#include "base/check.h"
#include "tools/launch/hosts.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  try {
    const tools::HostList list =
        tools::ParseHosts({reinterpret_cast<const char*>(data), size}, "hosts.json");
    for (const tools::Host& host : list.hosts) {
      for (const std::string& process : host.processes) {
        MUSTER_CHECK(list.Of(process) != nullptr, "{}", process);
        tools::OnHost(host, {process, {"muster-" + process}, ""});
      }
    }
    tools::CheckHosts(list, "hosts.json", {"world", "uav", "worker", "vehicle", "scheduler"}, {});
  } catch (const InputError&) {
  }
  return 0;
}

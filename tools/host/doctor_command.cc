#include "tools/host/doctor_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "base/options.h"
#include "base/program.h"
#include "tools/host/host_checks.h"

namespace muster::tools {
namespace {

const char* NameOf(HostCheck::Result result) {
  switch (result) {
    case HostCheck::Result::kOk:
      return "ok";
    case HostCheck::Result::kWarn:
      return "warn";
    case HostCheck::Result::kFail:
      return "fail";
  }
  return "?";
}

}  // namespace

int DoctorCommand(int argc, const char* const* argv) {
  Options options(argv[0],
                  "Looks whether this host can run missions: networks, LCM, kernel limits, "
                  "programs. Exits with 4 when a check failed.");
  options.Add("l,lcm-url", "URL", "URL that missions on the host's network would use")
      .Default(DefaultUrl());
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;

  const std::vector<HostCheck> checks = CheckHost(ParseMulticastUrl(arguments->Get("lcm-url")));
  fmt::print("{:<16} {:<6} {}\n", "check", "result", "found");
  for (const HostCheck& check : checks) {
    fmt::print("{:<16} {:<6} {}\n", check.name, NameOf(check.result), check.found);
    if (!check.advice.empty()) fmt::print("{:<23} -> {}\n", "", check.advice);
  }
  const auto count = [&](HostCheck::Result result) {
    return std::count_if(checks.begin(), checks.end(),
                         [&](const HostCheck& check) { return check.result == result; });
  };
  const auto failed = count(HostCheck::Result::kFail);
  fmt::print("{} checks, {} to improve, {} failed\n", checks.size(),
             count(HostCheck::Result::kWarn), failed);
  return failed > 0 ? kExitCheckFailed : kExitOk;
}

}  // namespace muster::tools

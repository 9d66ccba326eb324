#include "tools/launch/fault_options.h"

#include <limits>

namespace muster::tools {

void AddDropOption(Options* options) {
  options->Add("drop", "P", "Share of received packets that each process drops, 0 to 1")
      .Number({0, 1, false, true})
      .Default(0);
}

void AddFaultOptions(Options* options) {
  AddDropOption(options);
  options->Add("faults", "FILE", "Fault plan (docs/guide/faults.md)");
  options->Add("fault", "FAULT", "One more fault, e.g. loss:*@30+10=0.3 or process_killed:uav@45")
      .List();
  options
      ->Add("on-loss", "wait|continue",
            "What to do when an agent process or the scheduler is lost: wait for it, or continue "
            "without it until it is back")
      .OneOf({"wait", "continue"})
      .Default("wait");
  options->Add("lost-after", "S", "Seconds of silence after which a process is lost")
      .Number({0.5, 3600})
      .Default(5);
  options
      ->Add("restarts", "N",
            "How often each process that ends by itself is started again. With 0 the mission ends")
      .Integer(0, std::numeric_limits<int>::max())
      .Default(5);
}

FaultOptions ReadFaultOptions(const Arguments& arguments) {
  FaultOptions options;
  options.drop = arguments.Get<double>("drop");
  if (arguments.Has("faults")) options.faults = LoadFaultPlan(arguments.Get("faults"));
  for (const std::string& text : arguments.All("fault")) {
    options.faults.push_back(ParseFaultFlag(text, options.faults.size()));
  }
  options.on_loss = arguments.Get("on-loss");
  options.lost_after_s = arguments.Get<double>("lost-after");
  options.restarts = arguments.Get<int>("restarts");
  return options;
}

}  // namespace muster::tools

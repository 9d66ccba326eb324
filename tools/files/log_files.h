#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/seal.h"

namespace muster::tools {

/// The log files of a run, in the order in which they were written: `run` is a run directory
/// (mission.lcm, mission.lcm.1, ...) or one log file. Throws InputError when there is none.
std::vector<std::string> LogFilesOf(const std::string& run);

/// In the run directory of a sealed mission: the key of that run.
inline constexpr std::string_view kSealKeyFile = "seal.key";
/// Of one that is sealed per process: all senders with their public keys, and the folder with a
/// key for each process.
inline constexpr std::string_view kSealPublicFile = "seal.public";
inline constexpr std::string_view kProcessKeysFolder = "keys";
/// The key beside a log file; none if there is no file, or one that this user may not read. Throws
/// InputError if the file is not the key of a run.
std::optional<SealKey> KeyBeside(const std::string& log_file);

/// What tells the messages of the log's mission from others: of seal.public or the key beside the
/// log; none where neither is there. Throws InputError if they are none of a run.
std::optional<Seal> SealBeside(const std::string& log_file);

/// Opens one log file. Where a seal is beside it, messages without the right tag are left out.
std::unique_ptr<EventLogReader> OpenLog(const std::string& file, EventLogReader::Tail tail);

}  // namespace muster::tools

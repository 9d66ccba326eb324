#include "tools/log/log_merge.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "base/interval_set.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tools/files/pending_file.h"
#include "tools/log/log_source.h"

namespace muster::tools {
namespace {

using Id = std::tuple<std::string, std::int64_t, std::int64_t>;  // sender, boot_id, seq

/// Which messages there are.
class Ids {
 public:
  /// False: it was there.
  bool Add(const header_t& header) {
    return seqs_[{header.sender, header.boot_id}].Add(header.seq);
  }
  bool Contains(const header_t& header) const {
    const auto found = seqs_.find({header.sender, header.boot_id});
    return found != seqs_.end() && found->second.Contains(header.seq);
  }

 private:
  std::map<std::pair<std::string, std::int64_t>, IntervalSet> seqs_;
};

/// The messages of one mission in a log; what else it holds is left out.
class Messages {
 public:
  explicit Messages(const std::string& run) : source_(run) { source_.ShowProgress("merge"); }

  std::optional<LoggedMessage> Next() {
    while (auto message = source_.Next()) {
      if (message->header && FindChannel(message->packet.channel) != nullptr) return message;
    }
    return {};
  }
  void Rewind() { source_.Rewind(); }
  std::string name() const { return source_.name(); }

 private:
  LogSource source_;
};

void RequireRun(const header_t& header, const std::string& name,
                std::optional<std::int64_t>* run_id) {
  if (!*run_id) *run_id = header.run_id;
  if (header.run_id == **run_id) return;
  throw InputError(name, "run_id", fmt::to_string(header.run_id),
                   fmt::format("{}, the mission of the first log", **run_id));
}

Id IdOf(const header_t& header) { return {header.sender, header.boot_id, header.seq}; }

/// What the first log lacks, by the message behind which it comes; none: by nothing.
using Missing = std::map<std::optional<Id>, std::vector<LoggedMessage>>;

/// Adds what `messages` has and `all` has not. Returns how many.
std::int64_t AddMissing(const Ids& first, Messages* messages, std::optional<std::int64_t>* run_id,
                        Ids* all, Missing* missing) {
  std::int64_t added = 0;
  std::optional<Id> behind;
  while (auto message = messages->Next()) {
    RequireRun(*message->header, messages->name(), run_id);
    if (first.Contains(*message->header)) behind = IdOf(*message->header);
    if (!all->Add(*message->header)) continue;
    (*missing)[behind].push_back(*std::move(message));
    ++added;
  }
  return added;
}

void Write(Messages* first, const Missing& missing, const std::string& out, MergeResult* result) {
  PendingFile pending(out);
  {
    EventLogWriter writer(pending.temporary());
    const auto write = [&](const LoggedMessage& message) {
      writer.Write(message.received_us, WithTag(message.packet, message.tag));
      ++result->written;
    };
    const auto write_behind = [&](const std::optional<Id>& id) {
      const auto found = missing.find(id);
      if (found == missing.end()) return;
      for (const LoggedMessage& message : found->second) write(message);
    };
    write_behind({});
    Ids written;
    first->Rewind();
    while (const auto message = first->Next()) {
      if (!written.Add(*message->header)) continue;
      write(*message);
      write_behind(IdOf(*message->header));
    }
    writer.Flush();
  }
  pending.Commit();
}

}  // namespace

MergeResult MergeLogs(const std::vector<std::string>& runs, const std::string& out) {
  if (std::filesystem::exists(out)) {
    throw InputError("command line", "--out", out, "a file that does not exist");
  }
  MergeResult result;
  std::optional<std::int64_t> run_id;
  Messages first(runs.front());
  Ids of_first;
  std::int64_t count = 0;
  while (const auto message = first.Next()) {
    RequireRun(*message->header, first.name(), &run_id);
    count += of_first.Add(*message->header);
  }
  result.added.push_back(count);
  Ids all = of_first;
  Missing missing;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    Messages other(runs[i]);
    result.added.push_back(AddMissing(of_first, &other, &run_id, &all, &missing));
  }
  Write(&first, missing, out, &result);
  return result;
}

}  // namespace muster::tools

#include "tools/log/log_source.h"

#include "lcmtypes/bus/codec.h"
#include "tools/files/log_files.h"

namespace muster::tools {

LogSource::LogSource(const std::string& run) : files_(LogFilesOf(run)) { Rewind(); }

void LogSource::Rewind() {
  file_ = 0;
  if (progress_) progress_->Rewind();
  garbage_before_ = refused_before_ = 0;
  reader_ = OpenLog(files_[0], EventLogReader::Tail::kFinal);
}

std::optional<LoggedMessage> MessageSource::Next() {
  std::optional<LogEvent> event = NextEvent();
  if (!event) return {};
  LoggedMessage message{event->received_us, std::move(event->packet), std::move(event->tag), {}};
  message.header = DecodeHeader(message.packet);
  return message;
}

std::optional<LogEvent> LogSource::NextEvent() {
  while (true) {
    if (std::optional<LogEvent> event = reader_->Next()) {
      if (progress_) progress_->Add(*event);
      return event;
    }
    if (file_ + 1 == files_.size()) {
      if (progress_) progress_->Break();
      return {};
    }
    garbage_before_ += reader_->garbage_bytes();
    refused_before_ += reader_->refused();
    ++file_;
    reader_ = OpenLog(files_[file_], EventLogReader::Tail::kFinal);
  }
}

std::int64_t LogSource::refused() const { return refused_before_ + reader_->refused(); }

std::int64_t LogSource::garbage_bytes() const { return garbage_before_ + reader_->garbage_bytes(); }

}  // namespace muster::tools

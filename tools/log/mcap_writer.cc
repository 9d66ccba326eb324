#include "tools/log/mcap_writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "base/check.h"

namespace muster::tools {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kChunkBytes = 1 << 20;

enum Op : char {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// A record's content: little-endian integers, strings with a 32-bit length.
class Content {
 public:
  template <class T>
  Content& Put(T value) {
    static_assert(std::is_unsigned_v<T>);
    for (std::size_t i = 0; i < sizeof value; ++i) {
      bytes_ += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
    }
    return *this;
  }
  Content& Text(std::string_view text) {
    Put(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  Content& Raw(std::string_view bytes) {
    bytes_ += bytes;
    return *this;
  }
  std::string Record(Op op) const {
    std::string record(1, op);
    record += Content().Put(static_cast<std::uint64_t>(bytes_.size())).bytes_;
    return record + bytes_;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string MapOf(const std::map<std::uint16_t, std::uint64_t>& map) {
  Content content;
  for (const auto& [key, value] : map) content.Put(key).Put(value);
  return content.bytes();
}

}  // namespace

McapWriter::McapWriter(const std::string& path)
    : path_(path), file_(std::fopen(path.c_str(), "wb")) {
  if (!file_) throw SystemError(path + ": cannot write: " + std::strerror(errno));
  Append(kMagic);
  Append(Content().Text("").Text("muster").Record(kHeader));
}

void McapWriter::Append(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    throw SystemError(path_ + ": cannot write: " + std::strerror(errno));
  }
  position_ += bytes.size();
}

std::uint16_t McapWriter::AddChannel(const std::string& topic, const std::string& schema_name,
                                     const std::string& schema) {
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  schemas_.push_back(
      Content().Put(id).Text(schema_name).Text("jsonschema").Text(schema).Record(kSchema));
  channels_.push_back(Content().Put(id).Put(id).Text(topic).Text("json").Text("").Record(kChannel));
  chunk_ += schemas_.back() + channels_.back();
  counts_[id] = 0;
  return id;
}

void McapWriter::Write(std::uint16_t channel, std::uint64_t time_ns, std::string_view json) {
  if (index_.empty()) {
    chunk_first_ns_ = std::numeric_limits<std::uint64_t>::max();
    chunk_last_ns_ = 0;
  }
  chunk_first_ns_ = std::min(chunk_first_ns_, time_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, time_ns);
  index_[channel].push_back({time_ns, chunk_.size()});
  const auto sequence = static_cast<std::uint32_t>(counts_.at(channel)++);
  chunk_ +=
      Content().Put(channel).Put(sequence).Put(time_ns).Put(time_ns).Raw(json).Record(kMessage);
  if (chunk_.size() >= kChunkBytes) EndChunk();
}

void McapWriter::EndChunk() {
  if (chunk_.empty()) return;
  ChunkInfo info;
  info.first_ns = index_.empty() ? 0 : chunk_first_ns_;
  info.last_ns = index_.empty() ? 0 : chunk_last_ns_;
  info.start = position_;
  info.size = chunk_.size();
  Append(Content()
             .Put(info.first_ns)
             .Put(info.last_ns)
             .Put(info.size)
             .Put(std::uint32_t{0})
             .Text("")
             .Put(info.size)
             .Raw(chunk_)
             .Record(kChunk));
  info.length = position_ - info.start;
  const std::uint64_t index_start = position_;
  for (auto& [channel, entries] : index_) {
    info.index_offsets[channel] = position_;
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Indexed& a, const Indexed& b) { return a.time_ns < b.time_ns; });
    Content list;
    for (const Indexed& entry : entries) list.Put(entry.time_ns).Put(entry.offset);
    Append(Content().Put(channel).Text(list.bytes()).Record(kMessageIndex));
  }
  info.index_length = position_ - index_start;
  chunks_.push_back(std::move(info));
  chunk_.clear();
  index_.clear();
}

void McapWriter::Close() {
  EndChunk();
  Append(Content().Put(std::uint32_t{0}).Record(kDataEnd));
  const std::uint64_t summary_start = position_;
  std::string offsets;
  const auto group = [&](Op op, const std::vector<std::string>& records) {
    const std::uint64_t start = position_;
    for (const std::string& record : records) Append(record);
    if (records.empty()) return;
    offsets += Content()
                   .Put(static_cast<std::uint8_t>(op))
                   .Put(start)
                   .Put(position_ - start)
                   .Record(kSummaryOffset);
  };
  group(kSchema, schemas_);
  group(kChannel, channels_);
  std::uint64_t messages = 0;
  std::uint64_t first_ns = std::numeric_limits<std::uint64_t>::max(), last_ns = 0;
  std::vector<std::string> chunk_records;
  for (const ChunkInfo& c : chunks_) {
    chunk_records.push_back(Content()
                                .Put(c.first_ns)
                                .Put(c.last_ns)
                                .Put(c.start)
                                .Put(c.length)
                                .Text(MapOf(c.index_offsets))
                                .Put(c.index_length)
                                .Text("")
                                .Put(c.size)
                                .Put(c.size)
                                .Record(kChunkIndex));
    if (c.index_offsets.empty()) continue;
    first_ns = std::min(first_ns, c.first_ns);
    last_ns = std::max(last_ns, c.last_ns);
  }
  for (const auto& [channel, count] : counts_) messages += count;
  if (messages == 0) first_ns = 0;
  group(kStatistics, {Content()
                          .Put(messages)
                          .Put(static_cast<std::uint16_t>(schemas_.size()))
                          .Put(static_cast<std::uint32_t>(channels_.size()))
                          .Put(std::uint32_t{0})
                          .Put(std::uint32_t{0})
                          .Put(static_cast<std::uint32_t>(chunks_.size()))
                          .Put(first_ns)
                          .Put(last_ns)
                          .Text(MapOf(counts_))
                          .Record(kStatistics)});
  group(kChunkIndex, chunk_records);
  const std::uint64_t offset_start = position_;
  Append(offsets);
  Append(Content().Put(summary_start).Put(offset_start).Put(std::uint32_t{0}).Record(kFooter));
  Append(kMagic);
  if (std::fclose(file_.release()) != 0) {
    throw SystemError(path_ + ": cannot write: " + std::strerror(errno));
  }
}

}  // namespace muster::tools

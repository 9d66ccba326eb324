#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace muster::tools {

/// Writes MCAP version 0 (the specification at mcap.dev): uncompressed chunks with message indexes,
/// and a summary, so that readers can seek. No library for it is in Debian 12; a writer needs a
/// tenth of the format. Checksums are left out, which the format allows.
class McapWriter {
 public:
  /// Makes the file. Throws SystemError when it cannot, now or later.
  explicit McapWriter(const std::string& path);

  /// A schema in JSON Schema and a topic of JSON messages of that schema; returns the channel.
  std::uint16_t AddChannel(const std::string& topic, const std::string& schema_name,
                           const std::string& schema);
  void Write(std::uint16_t channel, std::uint64_t time_ns, std::string_view json);
  /// Ends the file. Without it, readers have to scan, and see the chunks that are complete.
  void Close();

 private:
  struct Indexed {
    std::uint64_t time_ns = 0;
    std::uint64_t offset = 0;
  };
  struct ChunkInfo {
    std::uint64_t first_ns = 0, last_ns = 0, start = 0, length = 0, size = 0, index_length = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void Append(std::string_view bytes);
  void EndChunk();

  std::string path_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::uint64_t position_ = 0;
  std::string definitions_;  ///< schema and channel records
  std::vector<std::string> schemas_, channels_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::string chunk_;
  std::map<std::uint16_t, std::vector<Indexed>> index_;
  std::uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
  std::vector<ChunkInfo> chunks_;
};

}  // namespace muster::tools

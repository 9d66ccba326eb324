#include "lcmtypes/bus/datagram_guard.h"

#include <dirent.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "lcmtypes/bus/limits.h"
#include "lcmtypes/bus/seal.h"

namespace muster {
namespace {

constexpr std::uint32_t kShortMagic = 0x4c433032;  // "LC02"
constexpr std::uint32_t kLongMagic = 0x4c433033;   // "LC03"

// Where things are, from the UDP header's first byte.
constexpr std::uint32_t kMagicAt = 8;
constexpr std::uint32_t kShortBodyAt = kMagicAt + 8;  // behind magic and the message's number
constexpr std::uint32_t kSizeAt = kMagicAt + 8;
constexpr std::uint32_t kOffsetAt = kMagicAt + 12;
constexpr std::uint32_t kNumberAt = kMagicAt + 16;  // two bytes
constexpr std::uint32_t kCountAt = kMagicAt + 18;   // two bytes
constexpr std::uint32_t kLongBodyAt = kMagicAt + 20;

// The machine's scratch memory.
constexpr std::uint32_t kLength = 0;   // of the body: all behind the header
constexpr std::uint32_t kNameEnd = 1;  // bytes of channel and NUL in the body
constexpr std::uint32_t kPayload = 2;  // bytes of the body that are the message's
constexpr std::uint32_t kRoom = 3;     // bytes of the message from the fragment's offset on

/// Builds a program. Every test is "drop unless": what follows it may rely on it.
class Builder {
 public:
  void Add(int code, std::uint32_t k = 0) { Jump(code, k, 0, 0); }
  void Jump(int code, std::uint32_t k, std::size_t if_true, std::size_t if_false) {
    program_.push_back({static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(if_true),
                        static_cast<std::uint8_t>(if_false), k});
  }
  void Pass() { Add(BPF_RET | BPF_K, 0xffffffff); }
  void Drop() { Add(BPF_RET | BPF_K, 0); }
  /// `code`: a comparison of A with k or, with BPF_X, with X.
  void DropUnless(int code, std::uint32_t k = 0) {
    Jump(BPF_JMP | code, k, 1, 0);
    Drop();
  }
  void DropIf(int code, std::uint32_t k = 0) {
    Jump(BPF_JMP | code, k, 0, 1);
    Drop();
  }
  /// A place that is not known yet to jump to, however far.
  std::size_t Leap() {
    Add(BPF_JMP | BPF_JA);
    return program_.size() - 1;
  }
  void LandHere(std::size_t leap) {
    program_[leap].k = static_cast<std::uint32_t>(program_.size() - leap - 1);
  }

  // A := bytes of the channel's name and its NUL; the body begins at `body_at`.
  void FindAnyName(std::uint32_t body_at);
  void FindOurName(std::uint32_t body_at, GuardedChannels channels);
  std::vector<sock_filter> Take() { return std::move(program_); }

 private:
  std::vector<std::size_t> FindOneOf(const std::vector<std::string>& names, std::size_t from,
                                     std::uint32_t body_at);

  std::vector<sock_filter> program_;
};

/// There are no loops: one test a byte.
void Builder::FindAnyName(std::uint32_t body_at) {
  std::vector<std::size_t> found;
  for (std::uint32_t i = 0; i <= kMostChannelBytes; ++i) {
    Add(BPF_LD | BPF_B | BPF_ABS, body_at + i);
    if (i > 0) {
      Jump(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 2);
      Add(BPF_LD | BPF_IMM, i + 1);
      found.push_back(Leap());
    }
    DropUnless(BPF_JGT | BPF_K, ' ');
    DropIf(BPF_JGT | BPF_K, '~');
  }
  Drop();
  for (const std::size_t leap : found) LandHere(leap);
}

/// LCM keeps every name that it has heard for ever: only those of the table. Every process does
/// this with every datagram of the mission, so it takes four bytes at a time.
void Builder::FindOurName(std::uint32_t body_at, GuardedChannels channels) {
  std::vector<std::string> names = {"LCM_SELF_TEST", kRoundTripChannel};
  for (const Channel& row : kChannels) {
    if (ComesThrough(row, channels)) names.emplace_back(row.name);
  }
  for (std::string& name : names) name.push_back('\0');
  const std::vector<std::size_t> found = FindOneOf(names, 0, body_at);
  Drop();
  for (const std::size_t leap : found) LandHere(leap);
}

/// `names` (with their NUL) are alike up to `from`, as is the datagram. Returns the leaps of those
/// that it has, and goes on where it has none. Nothing is read behind a name's NUL: a datagram may
/// end there, and a read beyond its end drops it. So short reads come first.
std::vector<std::size_t> Builder::FindOneOf(const std::vector<std::string>& names, std::size_t from,
                                            std::uint32_t body_at) {
  std::vector<std::size_t> found;
  for (const auto& [bytes, load] :
       {std::pair(1, BPF_B), std::pair(2, BPF_H), std::pair(4, BPF_W)}) {
    const auto step = static_cast<std::size_t>(bytes);
    std::map<std::uint32_t, std::vector<std::string>> groups;
    for (const std::string& name : names) {
      const std::size_t left = name.size() - from;
      if ((left >= 4 ? 4u : left >= 2 ? 2u : 1u) != step) continue;
      std::uint32_t value = 0;
      for (std::size_t i = from; i < from + step; ++i) {
        value = value << 8 | static_cast<unsigned char>(name[i]);
      }
      groups[value].push_back(name);
    }
    if (groups.empty()) continue;
    Add(BPF_LD | load | BPF_ABS, body_at + static_cast<std::uint32_t>(from));
    std::vector<std::size_t> ends;
    for (const auto& [value, group] : groups) {
      Jump(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
      const std::size_t differs = Leap();
      if (group.front().size() == from + step) {
        Add(BPF_LD | BPF_IMM, static_cast<std::uint32_t>(from + step));
        found.push_back(Leap());
      } else {
        const std::vector<std::size_t> longer = FindOneOf(group, from + step, body_at);
        found.insert(found.end(), longer.begin(), longer.end());
        ends.push_back(Leap());
      }
      LandHere(differs);
    }
    for (const std::size_t leap : ends) LandHere(leap);
  }
  return found;
}

/// A := bytes behind the header, which must be at least `least`.
void TakeBody(Builder* build, std::uint32_t body_at, std::uint32_t least) {
  build->Add(BPF_LD | BPF_W | BPF_LEN);
  build->DropUnless(BPF_JGE | BPF_K, body_at + least);
  build->Add(BPF_ALU | BPF_SUB | BPF_K, body_at);
  build->Add(BPF_ST, kLength);
}

void FindName(Builder* build, std::uint32_t body_at, GuardedChannels channels) {
  if (channels == GuardedChannels::kAny) {
    build->FindAnyName(body_at);
  } else {
    build->FindOurName(body_at, channels);
  }
}

/// X := that cell of the scratch memory.
void LoadX(Builder* build, std::uint32_t memory) { build->Add(BPF_LDX | BPF_W | BPF_MEM, memory); }

void CheckFragment(Builder* build, GuardedChannels channels) {
  TakeBody(build, kLongBodyAt, 1);
  build->Add(BPF_LD | BPF_W | BPF_ABS, kSizeAt);
  build->DropUnless(BPF_JGE | BPF_K, 1);
  build->DropIf(BPF_JGT | BPF_K, LargestMessage());

  // The first begins with the channel's name and has offset 0.
  build->Add(BPF_LD | BPF_W | BPF_IMM, 0);
  build->Add(BPF_ST, kNameEnd);
  build->Add(BPF_LD | BPF_H | BPF_ABS, kNumberAt);
  build->Jump(BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 0);
  const std::size_t not_first = build->Leap();
  build->Add(BPF_LD | BPF_W | BPF_ABS, kOffsetAt);
  build->DropUnless(BPF_JEQ | BPF_K, 0);
  FindName(build, kLongBodyAt, channels);
  build->Add(BPF_ST, kNameEnd);
  build->LandHere(not_first);

  // The name was found in the body, an offset in the message: nothing below runs over.
  build->Add(BPF_LD | BPF_W | BPF_ABS, kOffsetAt);
  build->Add(BPF_MISC | BPF_TAX);
  build->Add(BPF_LD | BPF_W | BPF_ABS, kSizeAt);
  build->DropUnless(BPF_JGE | BPF_X);
  build->Add(BPF_ALU | BPF_SUB | BPF_X);
  build->Add(BPF_ST, kRoom);
  build->Add(BPF_LD | BPF_MEM, kLength);
  LoadX(build, kNameEnd);
  build->Add(BPF_ALU | BPF_SUB | BPF_X);
  build->Add(BPF_ST, kPayload);
  LoadX(build, kRoom);
  build->DropIf(BPF_JGT | BPF_X);

  build->Add(BPF_LD | BPF_H | BPF_ABS, kCountAt);
  build->Add(BPF_MISC | BPF_TAX);
  build->Add(BPF_LD | BPF_H | BPF_ABS, kNumberAt);
  build->DropIf(BPF_JGE | BPF_X);
  build->Add(BPF_ALU | BPF_ADD | BPF_K, 1);
  build->Jump(BPF_JMP | BPF_JEQ | BPF_X, 0, 0, 5);
  // The last one ends the message.
  build->Add(BPF_LD | BPF_MEM, kPayload);
  LoadX(build, kRoom);
  build->DropUnless(BPF_JEQ | BPF_X);
  build->Pass();
  // One before it: all are of its size, but the last, which is smaller. 65535 times 65507 bytes
  // are below 2^32.
  build->Add(BPF_LD | BPF_MEM, kLength);
  build->Add(BPF_ALU | BPF_MUL | BPF_X);
  build->Add(BPF_MISC | BPF_TAX);
  build->Add(BPF_LD | BPF_W | BPF_ABS, kSizeAt);
  build->DropIf(BPF_JGT | BPF_X);
  build->Pass();
}

}  // namespace

bool ComesThrough(const Channel& channel, GuardedChannels channels) {
  switch (channels) {
    case GuardedChannels::kOfWorld:
      return channel.IsHeardBy(Hearer::kWorld);
    case GuardedChannels::kOfAgents:
      return channel.IsHeardBy(Hearer::kAgents);
    case GuardedChannels::kOfScheduler:
      return channel.IsHeardBy(Hearer::kScheduler);
    case GuardedChannels::kOurs:
    case GuardedChannels::kAny:
      break;
  }
  return true;
}

std::vector<sock_filter> DatagramGuard(GuardedChannels channels) {
  Builder build;
  build.Add(BPF_LD | BPF_W | BPF_ABS, kMagicAt);
  build.Jump(BPF_JMP | BPF_JEQ | BPF_K, kShortMagic, 1, 0);
  const std::size_t not_short = build.Leap();
  TakeBody(&build, kShortBodyAt, 2);
  FindName(&build, kShortBodyAt, channels);
  build.Pass();
  build.LandHere(not_short);
  build.DropUnless(BPF_JEQ | BPF_K, kLongMagic);
  CheckFragment(&build, channels);
  return build.Take();
}

std::optional<std::string> GuardSocket(int fd, GuardedChannels channels) {
  std::vector<sock_filter> program = DatagramGuard(channels);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0) return {};
  return fmt::format("SO_ATTACH_FILTER: {}", std::strerror(errno));
}

bool IsOnPort(int fd, std::uint16_t port) {
  int type = 0;
  socklen_t size = sizeof type;
  if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in bound{};
  size = sizeof bound;
  return getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) == 0 &&
         bound.sin_family == AF_INET && ntohs(bound.sin_port) == port;
}

std::vector<int> SocketsOnPort(std::uint16_t port) {
  std::vector<int> sockets;
  DIR* folder = opendir("/proc/self/fd");
  if (folder == nullptr) return sockets;
  while (const dirent* entry = readdir(folder)) {
    const int fd = std::atoi(entry->d_name);
    if (entry->d_name[0] != '.' && IsOnPort(fd, port)) sockets.push_back(fd);
  }
  closedir(folder);
  return sockets;
}

}  // namespace muster

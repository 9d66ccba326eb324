#include "lcmtypes/bus/codec.h"

#include <glib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>

#include "base/check.h"
#include "base/text.h"
#include "lcmtypes/bounds.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/words.h"
#include "muster/fields.h"

namespace muster {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kFingerprintBytes = 8;
/// Names, hosts, policies, fault ids.
constexpr std::size_t kMaxName = 256;
constexpr std::size_t kMaxDetail = 2048;
/// An order's JSON.
constexpr std::size_t kMaxOrder = 16 * 1024;

/// Walks over an encoded message without decoding it. Every step says whether the bytes were there.
class Scanner {
 public:
  explicit Scanner(Bytes bytes) : rest_(bytes) {}

  bool Skip(std::uint64_t n) {
    if (n > rest_.size()) return false;
    rest_ = rest_.subspan(n);
    return true;
  }

  bool ReadInt32(std::int32_t* value) {
    if (rest_.size() < 4) return false;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i) bits = bits << 8 | rest_[i];
    *value = static_cast<std::int32_t>(bits);
    return Skip(4);
  }

  /// Length with the closing NUL, characters, NUL; no NUL before.
  bool SkipString() {
    std::int32_t length = 0;
    if (!ReadInt32(&length) || length < 1) return false;
    const auto n = static_cast<std::size_t>(length);
    if (n > rest_.size() || rest_[n - 1] != 0) return false;
    if (n > 1 && std::memchr(rest_.data(), 0, n - 1) != nullptr) return false;
    return Skip(n);
  }

  std::size_t left() const { return rest_.size(); }

 private:
  Bytes rest_;
};

/// Whether a type has neither strings nor arrays.
template <class T>
bool HasFixedSize();

struct FixedSize {
  bool is = true;
  template <class T>
  void operator()(const char*, const T&) {
    if constexpr (std::is_same_v<T, std::string>) {
      is = false;
    } else if constexpr (!std::is_arithmetic_v<T>) {
      is = is && HasFixedSize<T>();
    }
  }
  void Count(const char*, std::int32_t) {}
  template <class T>
  void Array(const char*, const std::vector<T>&, std::int32_t) {
    is = false;
  }
};

template <class T>
bool HasFixedSize() {
  const T any{};
  FixedSize size;
  VisitFields(size, any);
  return size.is;
}

/// Encoded size of an element; 0: it differs from one to the next.
template <class T>
std::uint64_t FixedBytes() {
  if constexpr (std::is_arithmetic_v<T>) {
    return sizeof(T);
  } else {
    static const std::uint64_t bytes =
        HasFixedSize<T>() ? static_cast<std::uint64_t>(T()._getEncodedSizeNoHash()) : 0;
    return bytes;
  }
}

/// Goes over the bytes of a message field by field. The message that it visits takes up the counts
/// of arrays alone.
class FieldScanner {
 public:
  explicit FieldScanner(Scanner* in) : in_(*in) {}
  bool ok() const { return ok_; }

  template <class T>
  void operator()(const char*, T& field) {
    if (!ok_) return;
    if constexpr (std::is_same_v<T, std::string>) {
      ok_ = in_.SkipString();
    } else if constexpr (std::is_arithmetic_v<T>) {
      ok_ = in_.Skip(sizeof(T));
    } else {
      VisitFields(*this, field);
    }
  }
  void Count(const char*, std::int32_t& count) { ok_ = ok_ && in_.ReadInt32(&count) && count >= 0; }
  template <class T>
  void Array(const char*, const std::vector<T>&, std::int32_t count) {
    if (!ok_) return;
    if (const std::uint64_t bytes = FixedBytes<T>(); bytes > 0) {
      ok_ = in_.Skip(static_cast<std::uint64_t>(count) * bytes);
      return;
    }
    if constexpr (!std::is_arithmetic_v<T>) {
      T element{};
      for (std::int32_t i = 0; i < count && ok_; ++i) VisitFields(*this, element);
    }
  }

 private:
  Scanner& in_;
  bool ok_ = true;
};

std::uint64_t ReadFingerprint(Bytes bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kFingerprintBytes; ++i) value = value << 8 | bytes[i];
  return value;
}

/// How many bytes are behind the whole message that the bytes begin with; none: there is none.
template <class T>
std::optional<std::size_t> BytesBehind(Bytes bytes) {
  if (bytes.size() < kFingerprintBytes ||
      bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return std::nullopt;
  }
  if (ReadFingerprint(bytes) != static_cast<std::uint64_t>(T::getHash())) return std::nullopt;
  Scanner in(bytes.subspan(kFingerprintBytes));
  T counts{};
  FieldScanner fields(&in);
  VisitFields(fields, counts);
  if (!fields.ok()) return std::nullopt;
  return in.left();
}

struct TypeRow {
  std::string_view name;
  std::optional<std::size_t> (*bytes_behind)(Bytes);
  std::int64_t (*fingerprint)();
};

template <class T>
TypeRow RowOf() {
  return {T::getTypeName(), &BytesBehind<T>, &T::getHash};
}

const TypeRow* FindType(std::string_view name) {
  static const TypeRow rows[] = {
      RowOf<agent_states_t>(), RowOf<clock_t>(),      RowOf<event_t>(),
      RowOf<fault_t>(),        RowOf<log_status_t>(), RowOf<process_status_t>(),
      RowOf<request_t>(),      RowOf<restore_t>(),    RowOf<rulings_t>(),
      RowOf<roads_t>(),        RowOf<scenario_t>(),   RowOf<schedule_t>(),
      RowOf<world_state_t>(),  RowOf<answer_t>(),     RowOf<agent_changes_t>(),
      RowOf<order_t>(),        RowOf<orders_t>(),     RowOf<clearances_t>(),
      RowOf<proposal_t>(),
  };
  for (const TypeRow& row : rows) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

/// Whether each count is its array's length: generated encoders read `count` elements whatever the
/// array's length.
struct CountCheck {
  bool holds = true;
  template <class T>
  void operator()(const char*, const T& field) {
    if constexpr (!std::is_arithmetic_v<T> && !std::is_same_v<T, std::string>) {
      VisitFields(*this, field);
    }
  }
  void Count(const char*, std::int32_t) {}
  template <class T>
  void Array(const char*, const std::vector<T>& array, std::int32_t count) {
    holds = holds && count >= 0 && static_cast<std::size_t>(count) == array.size();
    if constexpr (!std::is_arithmetic_v<T>) {
      if (FixedBytes<T>() > 0) return;
      for (const T& element : array) VisitFields(*this, element);
    }
  }
};

template <class T>
bool CountsHold(const T& message) {
  CountCheck check;
  VisitFields(check, message);
  return check.holds;
}

bool In(std::int64_t value, std::int64_t low, std::int64_t high) {
  return low <= value && value <= high;
}
template <class... Times>
bool NotNegative(Times... values) {
  return ((values >= 0) && ...);
}
template <class... Ids>
bool AreIds(Ids... ids) {
  return ((ids >= -1) && ...);
}
template <class... Doubles>
bool Finite(Doubles... values) {
  return (std::isfinite(values) && ...);
}
/// Reports, pages and exports are UTF-8, and no name may steer the terminal that it is shown on.
bool IsText(const std::string& text, std::size_t longest) {
  return text.size() <= longest && !HasControls(text) &&
         g_utf8_validate(text.data(), static_cast<gssize>(text.size()), nullptr) != 0;
}
bool IsName(const std::string& text) { return IsText(text, kMaxName); }

/// An agent that set out for a damaged place beyond that would report times that no message can
/// carry.
bool IsPlace(double x_m, double y_m) {
  return std::abs(x_m) <= kFarthest_m && std::abs(y_m) <= kFarthest_m;
}

bool ValidAgent(const agent_t& a) {
  return a.id >= 0 && IsPlace(a.x_m, a.y_m) && IsPlace(a.from_x_m, a.from_y_m) &&
         Finite(a.speed_m_s, a.range_left_m, a.range_full_m, a.charge_rate_m_s,
                a.range_at_departure_m) &&
         NotNegative(a.speed_m_s, a.range_left_m, a.range_full_m, a.charge_rate_m_s,
                     a.range_at_departure_m, a.depart_us, a.arrive_us, a.online_from_us,
                     a.online_until_us, a.busy_until_us) &&
         IsWord<AgentStatus>(a.status) &&
         (a.action == ActionKind::kNone || IsWord<ActionKind>(a.action)) &&
         AreIds(a.target_id, a.partner_id, a.decision);
}
bool ValidAction(const action_t& a) {
  return IsWord<ActionKind>(a.kind) &&
         AreIds(a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id) &&
         IsPlace(a.x_m, a.y_m) && Finite(a.weight);
}
bool ValidActivity(const activity_t& a) {
  return IsWord<ActivityKind>(a.kind) &&
         NotNegative(a.uav_id, a.partner_id, a.site_id, a.start_us) && a.end_us >= a.start_us;
}
bool ValidRuling(const ruling_t& r) {
  return IsWord<AgentKind>(r.agent_kind) && IsWord<RulingKind>(r.kind) &&
         NotNegative(r.agent_id, r.at_us);
}

bool IsSha256(std::string_view text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

template <class T>
std::vector<std::uint8_t> Encode(const T& message) {
  MUSTER_CHECK(CountsHold(message), "{}: a count is not its array's length", T::getTypeName());
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  const int size = static_cast<int>(bytes.size());
  const int written = message.encode(bytes.data(), 0, size);
  MUSTER_CHECK(written == size, "{}: {} bytes of {}: NUL in a string?", T::getTypeName(), written,
               size);
  return bytes;
}

template <class T>
std::optional<T> Decode(Bytes bytes) noexcept {
  try {
    if (BytesBehind<T>(bytes) != 0) return std::nullopt;
    std::optional<T> message(std::in_place);
    const int size = static_cast<int>(bytes.size());
    if (message->decode(bytes.data(), 0, size) != size) return std::nullopt;
    return message;
  } catch (const std::exception&) {  // no memory even for what the input justifies
    return std::nullopt;
  }
}

bool Valid(const header_t& h) {
  return !h.sender.empty() && IsName(h.sender) &&
         NotNegative(h.boot_id, h.seq, h.sim_us, h.wall_us);
}
bool Valid(const agent_states_t& m) {
  return Valid(m.header) && IsWord<AgentKind>(m.kind) && m.tick >= 0 && m.applied_decision >= -1 &&
         std::all_of(m.agents.begin(), m.agents.end(), ValidAgent);
}
bool Valid(const agent_changes_t& m) {
  const auto in_order = [&](const agent_t& a, const agent_t& b) { return a.id >= b.id; };
  return Valid(m.header) && IsWord<AgentKind>(m.kind) && In(m.base_tick, 0, m.tick - 1) &&
         m.applied_decision >= -1 && In(m.first_id, 0, m.last_id) &&
         std::all_of(m.agents.begin(), m.agents.end(), ValidAgent) &&
         std::adjacent_find(m.agents.begin(), m.agents.end(), in_order) == m.agents.end() &&
         (m.agents.empty() ||
          (m.agents.front().id >= m.first_id && m.agents.back().id <= m.last_id));
}
bool Valid(const clearances_t& m) {
  const auto can_be = [&](const clearance_t& c) {
    return c.uav_id >= 0 && In(c.decision, 0, m.decision) && c.begin_us >= 0 && c.from_m >= 0 &&
           c.from_m <= kHighest_m && c.to_m >= 0 && c.to_m <= kHighest_m;
  };
  const auto in_order = [](const clearance_t& a, const clearance_t& b) {
    return a.uav_id >= b.uav_id;
  };
  return Valid(m.header) && NotNegative(m.decision, m.tick) &&
         std::all_of(m.clearances.begin(), m.clearances.end(), can_be) &&
         std::adjacent_find(m.clearances.begin(), m.clearances.end(), in_order) ==
             m.clearances.end();
}
bool Valid(const clock_t& m) {
  return Valid(m.header) && NotNegative(m.tick, m.tick_us, m.limit_us) && m.decision >= -1 &&
         m.required_decision >= -1 && IsWord<ClockPhase>(m.phase) &&
         (m.phase != ClockPhase::kReady || m.tick == 0) &&
         (m.phase != ClockPhase::kEnded || m.tick_us == m.limit_us);
}
bool Valid(const event_t& m) {
  return Valid(m.header) && IsWord<EventKind>(m.kind) && m.at_us >= 0 &&
         AreIds(m.uav_id, m.worker_id, m.vehicle_id, m.task_id, m.charge_id) &&
         IsName(m.fault_id) && IsText(m.detail, kMaxDetail);
}
bool Valid(const fault_t& m) {
  return Valid(m.header) && IsName(m.fault_id) && IsWord<FaultKind>(m.kind) && IsName(m.target) &&
         NotNegative(m.at_us, m.for_us) && m.probability >= 0 && m.probability <= 1;
}
bool Valid(const log_status_t& m) {
  return Valid(m.header) && std::all_of(m.marks.begin(), m.marks.end(), [](const log_mark_t& mark) {
           return !mark.sender.empty() && IsName(mark.sender) &&
                  NotNegative(mark.boot_id, mark.next_seq);
         });
}
bool Valid(const process_status_t& m) {
  return Valid(m.header) && IsName(m.name) && IsName(m.host) && m.pid >= 0 &&
         IsWord<ProcessState>(m.state) && m.tick >= -1 &&
         NotNegative(m.received, m.lost, m.rejected, m.resent, m.cpu_s, m.rss_bytes) &&
         Finite(m.cpu_s);
}
bool Valid(const order_t& m) {
  return Valid(m.header) && !m.id.empty() && IsName(m.id) && IsName(m.issuer) &&
         IsText(m.json, kMaxOrder);
}
bool Valid(const orders_t& m) {
  const auto can_be_taken = [](const taken_order_t& order) {
    return !order.id.empty() && IsName(order.id) && IsName(order.issuer) &&
           IsText(order.json, kMaxOrder) && IsWord<AgentKind>(order.agent_kind) &&
           AreIds(order.task_id, order.agent_id);
  };
  const auto can_be_refused = [](const refused_order_t& order) {
    return !order.id.empty() && IsName(order.id) && IsName(order.issuer) &&
           IsText(order.reason, kMaxDetail);
  };
  return Valid(m.header) && NotNegative(m.tick, m.before) &&
         std::all_of(m.taken.begin(), m.taken.end(), can_be_taken) &&
         std::all_of(m.refused.begin(), m.refused.end(), can_be_refused);
}
bool Valid(const order_book_t& m) {
  const auto in_order = [](const orders_t& a, const orders_t& b) { return a.tick >= b.tick; };
  return Valid(m.header) && m.tick >= -1 &&
         std::all_of(m.ticks.begin(), m.ticks.end(),
                     [](const orders_t& orders) { return Valid(orders); }) &&
         std::adjacent_find(m.ticks.begin(), m.ticks.end(), in_order) == m.ticks.end() &&
         (m.ticks.empty() || m.ticks.back().tick <= m.tick);
}
bool Valid(const request_t& m) { return Valid(m.header) && FindChannel(m.channel) != nullptr; }
bool Valid(const restore_t& m) {
  return Valid(m.header) && FindChannel(m.channel) != nullptr && m.tick >= -1;
}
bool Valid(const answer_t& m) {
  return Valid(m.header) && IsName(m.asker) && m.asker_boot_id >= 0 && m.asker_seq >= 0 &&
         FindChannel(m.channel) != nullptr && m.tick >= -1;
}
bool Valid(const rulings_t& m) {
  return Valid(m.header) && m.tick >= 0 &&
         std::all_of(m.rulings.begin(), m.rulings.end(), ValidRuling);
}
bool Valid(const roads_t& m) { return Valid(m.header) && IsSha256(m.sha256); }
bool Valid(const scenario_t& m) { return Valid(m.header) && IsSha256(m.sha256); }
bool Valid(const schedule_t& m) {
  return Valid(m.header) && NotNegative(m.decision, m.tick, m.candidates, m.solve_us) &&
         IsName(m.policy) && Finite(m.weight) && !std::isinf(m.bound) &&
         std::all_of(m.actions.begin(), m.actions.end(), ValidAction);
}
bool Valid(const proposal_t& m) {
  const auto of_its_decision = [&](const clearances_t& clearances) {
    return Valid(clearances) && clearances.decision == m.schedule.decision &&
           clearances.tick == m.schedule.tick;
  };
  return Valid(m.header) && Valid(m.schedule) && m.clearances.size() <= 1 &&
         std::all_of(m.clearances.begin(), m.clearances.end(), of_its_decision) &&
         std::all_of(m.events.begin(), m.events.end(),
                     [](const event_t& event) { return Valid(event); });
}
bool Valid(const world_state_t& m) {
  return Valid(m.header) && m.tick >= 0 && In(m.done, 0, m.n_tasks) &&
         std::all_of(m.task_status.begin(), m.task_status.end(), IsWord<TaskStatus>) &&
         std::all_of(m.activities.begin(), m.activities.end(), ValidActivity);
}

std::optional<header_t> DecodeHeader(const Packet& packet) noexcept {
  const Channel* channel = FindChannel(packet.channel);
  if (channel == nullptr) return std::nullopt;
  const TypeRow* type = FindType(channel->type);
  try {
    if (type == nullptr || type->bytes_behind(packet.bytes) != 0) return std::nullopt;
    std::optional<header_t> header(std::in_place);
    const int size = static_cast<int>(packet.bytes.size() - kFingerprintBytes);
    if (header->_decodeNoHash(packet.bytes.data(), kFingerprintBytes, size) < 0)
      return std::nullopt;
    if (!Valid(*header)) return std::nullopt;
    return header;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::optional<std::size_t> BytesBehindMessage(const Packet& packet) noexcept {
  const Channel* channel = FindChannel(packet.channel);
  const TypeRow* type = channel == nullptr ? nullptr : FindType(channel->type);
  if (type == nullptr) return std::nullopt;
  return type->bytes_behind(packet.bytes);
}

std::optional<std::uint64_t> Fingerprint(std::string_view type) noexcept {
  const TypeRow* row = FindType(type);
  if (row == nullptr) return std::nullopt;
  return static_cast<std::uint64_t>(row->fingerprint());
}

#define MUSTER_CODEC(T)                                   \
  template std::vector<std::uint8_t> Encode<T>(const T&); \
  template std::optional<T> Decode<T>(Bytes) noexcept
MUSTER_CODEC(agent_changes_t);
MUSTER_CODEC(agent_states_t);
MUSTER_CODEC(answer_t);
MUSTER_CODEC(clearances_t);
MUSTER_CODEC(clock_t);
MUSTER_CODEC(event_t);
MUSTER_CODEC(fault_t);
MUSTER_CODEC(log_status_t);
MUSTER_CODEC(order_book_t);
MUSTER_CODEC(order_t);
MUSTER_CODEC(orders_t);
MUSTER_CODEC(process_status_t);
MUSTER_CODEC(proposal_t);
MUSTER_CODEC(request_t);
MUSTER_CODEC(restore_t);
MUSTER_CODEC(roads_t);
MUSTER_CODEC(rulings_t);
MUSTER_CODEC(scenario_t);
MUSTER_CODEC(schedule_t);
MUSTER_CODEC(world_state_t);
#undef MUSTER_CODEC

}  // namespace muster

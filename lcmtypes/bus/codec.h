#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "muster/agent_changes_t.hpp"
#include "muster/agent_states_t.hpp"
#include "muster/answer_t.hpp"
#include "muster/clearances_t.hpp"
#include "muster/clock_t.hpp"
#include "muster/event_t.hpp"
#include "muster/fault_t.hpp"
#include "muster/log_status_t.hpp"
#include "muster/order_book_t.hpp"
#include "muster/order_t.hpp"
#include "muster/orders_t.hpp"
#include "muster/process_status_t.hpp"
#include "muster/proposal_t.hpp"
#include "muster/request_t.hpp"
#include "muster/restore_t.hpp"
#include "muster/roads_t.hpp"
#include "muster/rulings_t.hpp"
#include "muster/scenario_t.hpp"
#include "muster/schedule_t.hpp"
#include "muster/world_state_t.hpp"

namespace muster {

// Encode, Decode and Valid exist for each type of the channel table.

/// The message as LCM sends it, fingerprint first. A count that is not its array's length, or a
/// string with a NUL inside, is a broken invariant.
template <class T>
std::vector<std::uint8_t> Encode(const T& message);

/// The message, or none unless the bytes are exactly one message of that type: fingerprint, counts
/// and string lengths are checked against the bytes that are there before anything is allocated, so
/// memory stays within a small multiple of the input, and nothing may follow. Never throws. What it
/// accepts, Encode turns into the same bytes again. Values are not looked at: see Valid.
template <class T>
std::optional<T> Decode(std::span<const std::uint8_t> bytes) noexcept;

/// Whether all values are in ranges that need no scenario: finite numbers, known enumerators, ids
/// of at least -1, times and counters not negative (the ticks of process_status_t, restore_t and
/// answer_t: at least -1, none yet), names that are not endless, channels of the table.
bool Valid(const header_t& header);
bool Valid(const agent_changes_t& message);
bool Valid(const agent_states_t& message);
bool Valid(const clearances_t& message);
bool Valid(const clock_t& message);
bool Valid(const event_t& message);
bool Valid(const fault_t& message);
bool Valid(const log_status_t& message);
bool Valid(const order_book_t& message);
bool Valid(const order_t& message);
bool Valid(const orders_t& message);
bool Valid(const process_status_t& message);
bool Valid(const proposal_t& message);
bool Valid(const request_t& message);
bool Valid(const restore_t& message);
bool Valid(const answer_t& message);
bool Valid(const rulings_t& message);
bool Valid(const roads_t& message);
bool Valid(const scenario_t& message);
bool Valid(const schedule_t& message);
bool Valid(const world_state_t& message);

/// Decode, then Valid: what a receiver wants.
template <class T>
std::optional<T> DecodeValid(std::span<const std::uint8_t> bytes) noexcept {
  std::optional<T> message = Decode<T>(bytes);
  if (message && !Valid(*message)) message.reset();
  return message;
}

/// The valid header of a packet that is one whole message of its channel's type; else none. For
/// counting messages of any type, as a recorder does. Does not decode the rest.
std::optional<header_t> DecodeHeader(const Packet& packet) noexcept;

/// How many bytes a packet has behind the whole message of its channel's type that it begins with;
/// none where it begins with none, or the channel is not of the table. Does not decode it.
std::optional<std::size_t> BytesBehindMessage(const Packet& packet) noexcept;

/// The type's fingerprint, as in a message's first eight bytes; none for a name that is no type of
/// the channel table.
std::optional<std::uint64_t> Fingerprint(std::string_view type) noexcept;

}  // namespace muster

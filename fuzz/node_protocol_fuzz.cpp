#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/imu/packets/node_protocol.h"
#include "mien/sensor/sealed_protocol.h"

namespace {

using mien::imu::NodeProtocol;

constexpr std::uint64_t kSession = 0x1122334455667788;

mien::sensor::SealKey key() {
  mien::sensor::SealKey key{.id = 3};
  for (std::size_t i = 0; i < key.secret.size(); ++i) key.secret[i] = static_cast<std::byte>(i);
  return key;
}

template <class T>
T made(mien::Result<T> result) {
  if (!result) std::abort();
  return std::move(*result);
}

/// A host of paired nodes and glasses.
mien::sensor::SealedProtocol paired(const mien::sensor::SealKey& key) {
  std::vector<std::unique_ptr<mien::sensor::Protocol>> languages;
  languages.push_back(
      std::make_unique<mien::eyewear::EyewearProtocol>(made(mien::eyewear::EyewearProtocol::create())));
  languages.push_back(std::make_unique<NodeProtocol>(made(NodeProtocol::create({.session = kSession}))));
  return made(mien::sensor::SealedProtocol::create(kSession, {key}, std::move(languages)));
}

void check(mien::sensor::Protocol& host, std::span<const std::byte> datagram) {
  mien::sensor::Inbox inbox;
  const auto verdict = host.receive(mien::HostTime(), 1, datagram, inbox);
  const bool empty = inbox.readings.empty() && inbox.announcements.empty() && inbox.batteries.empty() &&
                     inbox.pulses.empty() && !inbox.alive && inbox.reply.empty();
  if (verdict != mien::sensor::Verdict::taken && !empty) std::abort();
  // What was refused or malformed leaves nothing for a log.
  if (verdict == mien::sensor::Verdict::refused || verdict == mien::sensor::Verdict::malformed)
    if (!inbox.opened.empty()) std::abort();
  if (!inbox.reply.empty() && !host.recognises(inbox.reply)) std::abort();
  // What was accepted goes back to the same bytes.
  const auto message = mien::imu::parse_node_message(datagram);
  if (!message) return;
  mien::ByteWriter writer;
  if (!encode_node_message(*message, writer)) std::abort();
  const auto again = writer.bytes();
  if (!std::equal(again.begin(), again.end(), datagram.begin(), datagram.end())) std::abort();
}

}  // namespace

// Datagrams, each after its length of two bytes, as they come; with its checksum put right; and sealed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mien::sensor::SealKey kKey = key();
  NodeProtocol open = made(NodeProtocol::create({.session = kSession}));
  mien::sensor::SealedProtocol keyed = paired(kKey);
  mien::ByteReader reader(std::as_bytes(std::span(data, size)));
  std::uint64_t counter = 0;
  while (reader.left() > 2) {
    const std::size_t length = std::min<std::size_t>(reader.little<std::uint16_t>(), reader.left());
    const auto datagram = reader.take(length);
    check(open, datagram);
    check(keyed, datagram);
    if (length < 4) continue;
    mien::ByteWriter right;
    right.append(datagram.first(length - 4));
    right.little(mien::crc32(datagram.first(length - 4)));
    check(open, right.bytes());
    check(keyed, right.bytes());
    mien::ByteReader device(right.bytes());
    device.take(8);
    mien::ByteWriter sealed;
    if (!seal_packet(kKey,
                     {.key_id = 3,
                      .device = device.little<std::uint64_t>(),
                      .counter = ++counter,
                      .session = kSession},
                     right.bytes(), sealed))
      continue;
    check(keyed, sealed.bytes());
  }
  return 0;
}

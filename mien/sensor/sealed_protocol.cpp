#include "mien/sensor/sealed_protocol.h"

#include <sodium.h>

#include <algorithm>

#include "mien/sensor/packet_envelope.h"

namespace mien::sensor {
namespace {

/// Most devices with replay windows: bounds memory against hostile key holders.
constexpr std::size_t kMaxSealedDevices = 256;
/// Of every packet of ours that can be sealed: magic, version, type, two bytes, then the device.
constexpr std::size_t kDeviceAt = 8;

/// Whether the packet is long enough to name a device, and names this one.
bool is_of(std::span<const std::byte> packet, std::uint64_t device) {
  ByteReader reader(packet);
  reader.take(kDeviceAt);
  const auto named = reader.little<std::uint64_t>();
  return reader.ok() && named == device;
}

}  // namespace

Result<SealedProtocol> SealedProtocol::create(std::uint64_t session, std::vector<SealKey> keys,
                                              std::vector<std::unique_ptr<Protocol>> languages) {
  const char* const where = "sealed protocol";
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", where);
  if (session == 0) return fail(ErrorCode::bad_usage, "a session without a token", where);
  if (keys.empty()) return fail(ErrorCode::bad_usage, "no key", where);
  std::ranges::sort(keys, {}, &SealKey::id);
  if (std::ranges::adjacent_find(keys, {}, &SealKey::id) != keys.end())
    return fail(ErrorCode::bad_usage, "two keys have one id", where);
  return SealedProtocol(session, std::move(keys), std::move(languages));
}

SealedProtocol::SealedProtocol(std::uint64_t session, std::vector<SealKey> keys,
                               std::vector<std::unique_ptr<Protocol>> languages)
    : session_(session), keys_(std::move(keys)), languages_(std::move(languages)) {}

bool SealedProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_our_packet(datagram);
}

Verdict SealedProtocol::receive(HostTime arrival, Peer peer, std::span<const std::byte> datagram,
                                Inbox& inbox) {
  if (!is_sealed(datagram)) return Verdict::refused;
  const auto header = open_sealed(keys_, datagram, inbox.opened);
  if (!header) {
    const ErrorCode code = header.error().code;
    return code == ErrorCode::unsupported || code == ErrorCode::mismatch ? Verdict::refused
                                                                         : Verdict::malformed;
  }
  Verdict verdict = Verdict::refused;
  const auto language =
      std::ranges::find_if(languages_, [&](const auto& one) { return one->recognises(inbox.opened); });
  if (language != languages_.end() && admit(*header, inbox.opened)) {
    verdict = (*language)->receive(arrival, peer, inbox.opened, inbox);
    if (!inbox.reply.empty()) seal_reply(*header, inbox);
  }
  if (verdict == Verdict::malformed || verdict == Verdict::refused) inbox.opened.clear();
  return verdict;
}

bool SealedProtocol::admit(const SealHeader& header, std::span<const std::byte> inner) {
  if ((header.counter & SealHeader::kFromHost) != 0) return false;
  // What is no packet of ours (a line of text) names no device, and may be anybody's.
  if (!is_our_packet(inner) || !is_of(inner, header.device)) return false;
  // What an earlier session heard has another token, and is not heard again.
  if (header.session != session_ && !is_our_packet(inner, kHelloPacketType)) return false;
  const std::pair key(header.key_id, header.device);
  if (windows_.size() == kMaxSealedDevices && !windows_.contains(key)) return false;
  return windows_[key].accept(header.counter);
}

void SealedProtocol::seal_reply(const SealHeader& to, Inbox& inbox) {
  const auto key = std::ranges::find(keys_, to.key_id, &SealKey::id);
  sealed_.clear();
  const auto sealed = seal_packet(*key,
                                  {.key_id = to.key_id,
                                   .device = to.device,
                                   .counter = SealHeader::kFromHost | sent_++,
                                   .session = session_},
                                  inbox.reply, sealed_);
  // A reply that cannot be sealed would be a defect of its language; nothing is said then.
  inbox.reply.assign(sealed_.bytes().begin(), sealed ? sealed_.bytes().end() : sealed_.bytes().begin());
}

}  // namespace mien::sensor

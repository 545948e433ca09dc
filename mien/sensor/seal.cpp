#include "mien/sensor/seal.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>

#include "mien/sensor/packet_envelope.h"

namespace mien::sensor {
namespace {

constexpr std::size_t kSealHeaderBytes = 32;
constexpr std::size_t kNonceAt = 8;  // Device, counter and session are the nonce.
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
static_assert(kSealHeaderBytes - kNonceAt == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES);
static_assert(sizeof(SealKey::secret) == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);

const char* const kSealedPacket = "sealed packet";

const unsigned char* raw(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

}  // namespace

Result<void> seal_packet(const SealKey& key, const SealHeader& header, std::span<const std::byte> inner,
                         ByteWriter& out) {
  if (key.id != header.key_id)
    return fail(ErrorCode::bad_usage, "the header names another key", kSealedPacket);
  if (inner.empty() || inner.size() > kMaxSealedInner || is_sealed(inner))
    return fail(ErrorCode::bad_usage, "this cannot be sealed", kSealedPacket);
  const std::size_t begin = out.bytes().size();
  write_packet_begin(kSealedPacketType, out);
  out.little(header.key_id);
  out.little(std::uint8_t{0});
  out.little(header.device);
  out.little(header.counter);
  out.little(header.session);
  std::array<std::byte, kMaxSealedInner + kTagBytes> cipher;
  unsigned long long size = 0;
  const auto open = out.bytes().subspan(begin, kSealHeaderBytes);
  crypto_aead_xchacha20poly1305_ietf_encrypt(reinterpret_cast<unsigned char*>(cipher.data()), &size,
                                             raw(inner), inner.size(), raw(open), open.size(), nullptr,
                                             raw(open.subspan(kNonceAt)), raw(key.secret));
  out.append(std::span(cipher).first(static_cast<std::size_t>(size)));
  write_checksum(begin, out);
  return {};
}

bool is_sealed(std::span<const std::byte> bytes) {
  return is_our_packet(bytes, kSealedPacketType);
}

Result<SealHeader> open_sealed(std::span<const SealKey> keys, std::span<const std::byte> bytes,
                               std::vector<std::byte>& inner) {
  inner.clear();
  if (bytes.size() <= kSealHeaderBytes + kTagBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kSealedPacket);
  ByteReader reader(bytes);
  MIEN_TRY_ASSIGN(const std::uint8_t type, read_packet_begin(reader, kSealedPacket));
  if (type != kSealedPacketType)
    return fail(ErrorCode::unsupported, "a packet that is not sealed", kSealedPacket);
  const std::size_t size = bytes.size() - kSealHeaderBytes - kTagBytes - kChecksumBytes;
  if (size > kMaxSealedInner) return fail(ErrorCode::malformed, "too long", kSealedPacket);
  MIEN_TRY(check_checksum(bytes, kSealedPacket));
  SealHeader header;
  header.key_id = reader.little<std::uint8_t>();
  if (reader.little<std::uint8_t>() != 0)
    return fail(ErrorCode::malformed, "a reserved byte is set", kSealedPacket);
  header.device = reader.little<std::uint64_t>();
  header.counter = reader.little<std::uint64_t>();
  header.session = reader.little<std::uint64_t>();

  const auto key =
      std::find_if(keys.begin(), keys.end(), [&](const SealKey& k) { return k.id == header.key_id; });
  if (key == keys.end())
    return fail(ErrorCode::mismatch, fmt::format("key {} is not known here", header.key_id), kSealedPacket);
  const auto open = bytes.first(kSealHeaderBytes);
  const auto cipher = bytes.subspan(kSealHeaderBytes, size + kTagBytes);
  inner.resize(size);
  unsigned long long opened = 0;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(reinterpret_cast<unsigned char*>(inner.data()), &opened,
                                                 nullptr, raw(cipher), cipher.size(), raw(open), open.size(),
                                                 raw(open.subspan(kNonceAt)), raw(key->secret)) != 0) {
    inner.clear();
    return fail(ErrorCode::mismatch, "not sealed with this key, or changed since", kSealedPacket);
  }
  return header;
}

bool ReplayWindow::accept(std::uint64_t counter) {
  if (seen_ == 0) {
    newest_ = counter;
    seen_ = 1;
    return true;
  }
  if (counter > newest_) {
    const std::uint64_t ahead = counter - newest_;
    seen_ = ahead < kWidth ? seen_ << ahead | 1U : 1U;
    newest_ = counter;
    return true;
  }
  const std::uint64_t behind = newest_ - counter;
  if (behind >= kWidth) return false;
  const std::uint64_t bit = std::uint64_t{1} << behind;
  if ((seen_ & bit) != 0) return false;
  seen_ |= bit;
  return true;
}

}  // namespace mien::sensor

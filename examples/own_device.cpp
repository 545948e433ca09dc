// How does a device of one's own come into a session? By two classes: a protocol, which knows its bytes, and
// a tracker, which knows what its samples mean. Here a sensor of the jaw's opening becomes the jaw's weight.

#include <fmt/format.h>

#include <cmath>

#include "mien/core/bytes.h"
#include "mien/session/session.h"

namespace {
using namespace mien;

constexpr sensor::SampleKind kOpening{200};  // Takes keep it: one number for ever.
constexpr std::size_t kJaw = face::shape("jawOpen");

/// "JAW!", number (4 bytes), time in us (8 bytes), opening from 0 to 1 (a float); little-endian.
struct JawProtocol final : sensor::Protocol {
  std::string_view name() const override { return "jaw"; }
  bool recognises(std::span<const std::byte> d) const override { return as_text(d).starts_with("JAW!"); }
  sensor::Verdict receive(HostTime, sensor::Peer, std::span<const std::byte> d, sensor::Inbox& in) override {
    ByteReader reader(d.subspan(4));
    const auto number = reader.little<std::uint32_t>();
    const auto time_us = reader.little<std::uint64_t>();
    const auto opening = reader.little<float>();
    // What comes from outside is hostile: cut short, too long, years away, not a number.
    if (!reader.ok() || reader.left() > 0 || time_us > 100'000'000'000'000 || !(opening >= 0 && opening <= 1))
      return sensor::Verdict::malformed;
    const DeviceTime time(std::chrono::microseconds{time_us});
    in.readings.push_back({.from = {1, 0}, .sample = {0, kOpening, number, time, false, 1, {opening}}});
    return sensor::Verdict::taken;
  }
};

struct JawTracker final : tracker::Tracker {  // With nothing to calibrate.
  float opening = 0;
  std::string_view modality() const override { return "jaw"; }
  void add(HostTime, const sensor::Sample& sample) override { opening = sample.values[0]; }
  void forget(std::uint16_t) override { opening = 0; }
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, face::OutputFrame& out) override {
    out = {.time = frame};
    out.weights[kJaw] = opening;
    out.confidence[kJaw] = 1;
    out.provenance.fill(face::Provenance::neutral);
    out.provenance[kJaw] = face::Provenance::measured;
    return {.sensors_present = 1};
  }
};
}  // namespace

int main() {
  session::Session::Parts parts;
  const sensor::Mount chin{.name = "chin", .kind = "jaw", .role = "face", .device = "00:00:00:00:00:01"};
  parts.rig = {.name = "toy", .reference = "chin", .sensors = {chin}};
  parts.trackers.push_back(std::make_unique<JawTracker>());
  parts.protocols.push_back(std::make_unique<JawProtocol>());
  const auto session = session::Session::create(std::move(parts)).value();
  for (std::uint32_t i = 0; i < 400; ++i) {  // Two seconds: every 5 ms a datagram.
    const HostTime now(std::chrono::milliseconds(5 * i + 3));
    while (const auto due = session->due(now))
      fmt::print("{:.3f} s  jawOpen {:.2f}\n", to_seconds(due->frame.time_since_epoch()),
                 session->tick(due->frame, due->fired).weights[kJaw]);
    ByteWriter out;
    out.append("JAW!");
    out.little(i);
    out.little(std::uint64_t{5000} * i);
    out.little(static_cast<float>(0.5 - 0.5 * std::cos(0.0314 * i)));
    static_cast<void>(session->receive(now, 0, out.bytes()));
  }
}

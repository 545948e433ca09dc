#include "mien/session/receiver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mien/sensor/bindings.h"
#include "mien/sensor/sample_values.h"
#include "mien/shaping/merge.h"

namespace mien::session {
namespace {

using sensor::DeviceKey;
using sensor::Verdict;

/// A device that was received from one place lately is not accepted from another: two with one id.
constexpr Duration kSamePlace = std::chrono::seconds(1);
/// For so long where somebody else sent as it while it did: who was there beside the device is not the
/// device.
constexpr Duration kContestedPlace = std::chrono::seconds(10);
/// Who was accepted for longer than the one that followed has been gets the place again when it is back
/// within this.
constexpr Duration kReturn = std::chrono::minutes(1);
/// Where a board sends no readings while nothing changes, its other datagrams hold its place for so long.
constexpr Duration kUnchangedPlace = std::chrono::seconds(5);
/// Nor is one whose time is so far from its last, ...
constexpr Duration kSameClock = std::chrono::seconds(1);
/// ... unless it was silent for as long as a board takes to restart.
constexpr Duration kSameBoard = std::chrono::milliseconds(300);
/// Who was silent for so long is no rival any more, and news when it is back.
constexpr Duration kContest = std::chrono::seconds(10);
/// A sensor has dropped out when nothing was received of it for this long, ...
constexpr Duration kLost = std::chrono::milliseconds(100);
/// ... or, where the board sends nothing while nothing changes, for this.
constexpr Duration kLostEstimated = std::chrono::seconds(1);
/// Samples that one datagram can hold.
constexpr std::size_t kMostSamples = 256;
/// Unknown versions that are told apart: nobody has so many, and a stranger could invent more.
constexpr std::size_t kMostVersions = 8;

}  // namespace

std::string_view link_change_name(LinkChange change) {
  // In the order of LinkChange.
  static constexpr std::array<std::string_view, 4> kNames = {"sensor_lost", "sensor_back", "face_lost",
                                                             "face_back"};
  return kNames.at(static_cast<std::size_t>(change));
}

Result<std::unique_ptr<Receiver>> Receiver::create(sensor::Rig rig,
                                                   std::vector<std::unique_ptr<sensor::Protocol>> protocols,
                                                   std::vector<ProtocolReducer> reducers) {
  MIEN_TRY_ASSIGN(auto bound, sensor::bindings(rig));
  std::vector<std::unique_ptr<sensor::Reducer>> by_protocol(protocols.size());
  for (ProtocolReducer& one : reducers) {
    const auto found =
        std::ranges::find_if(protocols, [&](const auto& p) { return p->name() == one.protocol; });
    const auto place = static_cast<std::size_t>(found - protocols.begin());
    if (found == protocols.end() || by_protocol[place] != nullptr)
      return fail(ErrorCode::bad_usage, "the payloads' reducer has no protocol, or is its second",
                  one.protocol);
    if (!sensor::is_reducer_hash(one.reducer->hash()))
      return fail(ErrorCode::bad_usage, "the payloads' reducer has no SHA-256", one.protocol);
    by_protocol[place] = std::move(one.reducer);
  }
  return std::unique_ptr<Receiver>(
      new Receiver(std::move(rig), std::move(protocols), std::move(by_protocol), std::move(bound)));
}

Receiver::Receiver(sensor::Rig rig, std::vector<std::unique_ptr<sensor::Protocol>> protocols,
                   std::vector<std::unique_ptr<sensor::Reducer>> reducers,
                   std::vector<std::pair<DeviceKey, std::uint16_t>> bound)
    : rig_(std::move(rig)),
      protocols_(std::move(protocols)),
      ticks_(rig_),
      links_(rig_.sensors.size()),
      bound_(std::move(bound)),
      reducers_(std::move(reducers)) {
  for (const sensor::Mount& mount : rig_.sensors)
    views_.push_back(mount.camera ? std::optional(sensor::view_of(*mount.camera)) : std::nullopt);
  devices_.reserve(kMaxDevices + rig_.sensors.size());
  bound_.reserve(kMaxDevices + rig_.sensors.size());
  samples_.reserve(kMostSamples);
  inbox_.readings.reserve(kMostSamples);
  if (std::ranges::any_of(reducers_, [](const auto& reducer) { return reducer != nullptr; }))
    reduction_.resize(sensor::kMaxPayload);
}

const Receiver::Device* Receiver::find(const DeviceKey& key) const {
  const auto found = std::ranges::find(devices_, key, &Device::key);
  return found == devices_.end() ? nullptr : &*found;
}

Receiver::Device* Receiver::find(const DeviceKey& key) {
  return const_cast<Device*>(std::as_const(*this).find(key));
}

Receiver::Device& Receiver::meet(const DeviceKey& key, Sender sender, std::size_t protocol,
                                 HostTime arrival) {
  if (Device* known = find(key)) return *known;
  // A stranger's inventions must not keep boards out, neither the rig's own nor those that are to be bound:
  // of the others the one gives way that was silent longest.
  Device* place = nullptr;
  if (devices_.size() >= kMaxDevices + rig_.sensors.size())
    for (Device& one : devices_)
      if (!one.sensor && (place == nullptr || one.received < place->received)) place = &one;
  Device& met = place != nullptr ? *place : devices_.emplace_back();
  met = Device();
  met.key = key;
  met.peer = sender.peer;
  met.source = sender.source;
  met.received = met.accepted_since = arrival;
  met.protocol = protocol;
  for (const auto& [bound, sensor] : bound_)
    if (bound == key) met.sensor = sensor;
  return met;
}

void Receiver::bind(std::uint16_t sensor, const DeviceKey& key, SampleConsumer& consumer) {
  if (std::ranges::find(bound_, std::pair(key, sensor)) != bound_.end()) return;
  std::erase_if(bound_, [&](const auto& b) { return b.first == key || b.second == sensor; });
  bound_.emplace_back(key, sensor);
  for (Device& known : devices_) {
    if (known.sensor == sensor) known.sensor.reset();
    if (known.key != key) continue;
    if (known.sensor) links_[*known.sensor] = Link();
    known.sensor = sensor;
  }
  for (const auto& reducer : reducers_)
    if (reducer != nullptr) reducer->bind(sensor, key);
  const bool was_received = links_[sensor].received.has_value();
  links_[sensor] = Link();
  ticks_.forget(sensor);
  consumer.rebound(sensor, key, was_received);
}

Result<void> Receiver::change_view(std::uint16_t sensor, const sensor::PictureViewChange& change,
                                   SampleConsumer& consumer) {
  const std::string& name = rig_.sensors[sensor].name;
  std::optional<sensor::PictureView>& view = views_[sensor];
  if (!view) return fail(ErrorCode::mismatch, fmt::format("{} is no camera", name), "view");
  MIEN_TRY_ASSIGN(const sensor::PictureView changed, sensor::changed_view(*view, change, name));
  if (changed == *view) return {};
  view = changed;
  for (const auto& reducer : reducers_)
    if (reducer != nullptr) reducer->change_view(sensor, changed);
  consumer.view_changed(sensor, changed, links_[sensor].received.has_value());
  return {};
}

bool Receiver::is_received(const Device& device, HostTime arrival) {
  const Duration silent = arrival - device.received;
  const bool contested = device.contested_beside && device.received - *device.contested_beside <= kContest;
  if (silent < (contested ? kContestedPlace : kSamePlace)) return true;
  return device.estimated && silent < kUnchangedPlace && arrival - device.alive < kSamePlace;
}

Receiver::Rival* Receiver::rival_of(Device& device, HostTime arrival, Sender sender) {
  auto rival = std::ranges::find_if(device.rivals,
                                    [&](const Rival& r) { return r.received && r.peer == sender.peer; });
  if (rival != device.rivals.end()) return &*rival;
  // A place of one who is silent, or else of one who is no sensor either.
  rival = std::ranges::find_if(
      device.rivals, [&](const Rival& r) { return !r.received || arrival - *r.received > kSamePlace; });
  if (rival == device.rivals.end())
    rival =
        std::ranges::find_if(device.rivals, [](const Rival& r) { return r.plausibility.is_implausible(); });
  if (rival == device.rivals.end()) return nullptr;
  rival->peer = sender.peer;
  rival->source = sender.source;
  rival->plausibility = {};
  return &*rival;
}

void Receiver::change_places(Device& device, Rival& rival, SampleConsumer& consumer) {
  std::swap(device.peer, rival.peer);
  std::swap(device.source, rival.source);
  std::swap(device.plausibility, rival.plausibility);
  std::swap(device.received, *rival.received);
  device.alive = device.accepted_since = device.received;
  device.newest = {};
  device.chosen = false;
  device.former.reset();
  if (!device.sensor) return;
  links_[*device.sensor] = Link();
  ticks_.forget(*device.sensor);
  consumer.rebound(*device.sensor, device.key, true);
  consumer.contested(*device.sensor, device.source, rival.source);
}

bool Receiver::judge_rival(Device& device, HostTime arrival, Sender sender, const sensor::Sample& sample,
                           SampleConsumer& consumer) {
  if (!device.sensor) return false;
  if (!device.contested || arrival - *device.contested > kContest)
    consumer.contested(*device.sensor, device.source, sender.source);
  device.contested = arrival;
  Rival* const rival = rival_of(device, arrival, sender);
  if (rival == nullptr) return false;
  rival->received = arrival;
  rival->plausibility.add(arrival, sample);
  if (device.chosen || !device.plausibility.is_implausible() || !rival->plausibility.is_plausible())
    return false;
  change_places(device, *rival, consumer);
  return true;
}

void Receiver::follow(Device& device, HostTime arrival, Sender sender) {
  for (Rival& rival : device.rivals)
    if (rival.peer == sender.peer) rival.received.reset();
  const Duration accepted_for = device.received - device.accepted_since;
  if (!device.former || arrival - device.former->received > kReturn ||
      device.former->accepted_for <= accepted_for)
    device.former = Former{.peer = device.peer,
                           .source = device.source,
                           .plausibility = device.plausibility,
                           .received = device.received,
                           .newest = device.newest,
                           .accepted_for = accepted_for};
  device.peer = sender.peer;
  device.source = sender.source;
  device.plausibility = {};
  device.accepted_since = arrival;
  device.contested.reset();
  device.contested_beside.reset();
  device.chosen = false;
}

bool Receiver::returns(const Device& device, HostTime arrival, Sender sender, DeviceTime time) {
  if (!device.former || device.chosen) return false;
  const Former& former = *device.former;
  const Duration gone = arrival - former.received;
  const Duration off = (time - former.newest) - gone;
  return former.peer == sender.peer && gone <= kReturn && off <= kSameClock && off >= -kSameClock &&
         former.accepted_for > arrival - device.accepted_since && former.plausibility.is_plausible();
}

void Receiver::give_back(Device& device, HostTime arrival, SampleConsumer& consumer) {
  Former former = *std::exchange(device.former, std::nullopt);
  if (Rival* const rival = rival_of(device, arrival, {device.peer, device.source})) {
    rival->received = device.received;
    rival->plausibility = device.plausibility;
  }
  for (Rival& rival : device.rivals)
    if (rival.peer == former.peer) rival.received.reset();
  device.peer = former.peer;
  device.plausibility = former.plausibility;
  device.accepted_since = arrival - former.accepted_for;
  device.contested = device.contested_beside = device.received;
  device.newest = {};
  device.source.swap(former.source);
  if (!device.sensor) return;
  // The clock was another's meanwhile; what is known of the board itself holds.
  ticks_.forget(*device.sensor);
  consumer.contested(*device.sensor, device.source, former.source);
}

bool Receiver::hear(std::uint16_t sensor, std::string_view source, SampleConsumer& consumer) {
  const auto rival_in = [&](Device& device) {
    const auto found =
        std::ranges::find_if(device.rivals, [&](const Rival& r) { return r.received && r.source == source; });
    return found == device.rivals.end() ? nullptr : &*found;
  };
  const auto asked =
      std::ranges::find_if(devices_, [&](const Device& device) { return device.sensor == sensor; });
  if (source.empty() || asked == devices_.end() || (asked->source != source && rival_in(*asked) == nullptr))
    return false;
  // A board's sensors come from one place.
  const std::uint64_t board = asked->key.device;
  for (Device& device : devices_) {
    if (device.key.device != board) continue;
    if (device.source != source) {
      Rival* const rival = rival_in(device);
      if (rival == nullptr) continue;
      change_places(device, *rival, consumer);
    }
    device.chosen = true;
  }
  return true;
}

void Receiver::take_reading(HostTime arrival, Sender sender, std::size_t protocol,
                            const sensor::Reading& reading, SampleConsumer& consumer) {
  Device* const from = &meet(reading.from, sender, protocol, arrival);
  // Another place, or another clock, while the one that is known still sends.
  const Duration silent = arrival - from->received;
  const Duration off = (reading.sample.time - from->newest) - silent;
  const bool other_clock = from->newest != DeviceTime{} && (off > kSameClock || off < -kSameClock);
  const bool elsewhere = from->peer != sender.peer && is_received(*from, arrival);
  if (elsewhere && returns(*from, arrival, sender, reading.sample.time)) {
    give_back(*from, arrival, consumer);
    return take_reading(arrival, sender, protocol, reading, consumer);
  }
  bool impostor = elsewhere || (other_clock && silent < kSameBoard);
  if (elsewhere) {
    if (judge_rival(*from, arrival, sender, reading.sample, consumer)) impostor = false;
  } else {
    if (from->peer != sender.peer)
      follow(*from, arrival, sender);
    else if (silent >= kSamePlace)
      from->accepted_since += silent;  // A pause is no time in which it was accepted.
    from->plausibility.add(arrival, reading.sample);
  }
  if (!impostor) {
    from->contested_beside = from->contested;
    from->received = arrival;
    from->newest = reading.sample.time;
    from->estimated = reading.sample.time_estimated;
    if (const auto tapped = tap_.add(arrival, reading)) {
      const auto sensor = rig_.find(tap_.armed());
      tap_.arm({});
      if (sensor) bind(*sensor, *tapped, consumer);
    }
    if (const auto covered = cover_.add(arrival, reading))
      if (const auto sensor = rig_.find(covered->sensor)) bind(*sensor, covered->device, consumer);
  }
  if (!from->sensor) return;
  Link& link = links_[*from->sensor];
  link.health.add(arrival, reading.sample, reading.saturated);
  if (impostor) return;
  link.received = arrival;
  link.newest = reading.sample.time;
  link.level = sensor::level(reading.sample);
  link.estimated = reading.sample.time_estimated;
  sensor::Sample& sample = samples_.emplace_back(reading.sample);
  sample.sensor = *from->sensor;
  ticks_.add(arrival, sample);
  if (rig_.sensors[*from->sensor].is_truth()) return;
  consumer.add(arrival, sample, reading.payload);
}

bool Receiver::speaks_from(const DeviceKey& key, sensor::Peer peer) const {
  const Device* const device = find(key);
  return device != nullptr && device->peer == peer;
}

std::size_t Receiver::protocol_of(std::span<const std::byte> datagram) const {
  std::size_t protocol = 0;
  while (protocol < protocols_.size() && !protocols_[protocol]->recognises(datagram)) ++protocol;
  return protocol;
}

void Receiver::note_version(std::size_t protocol, Sender sender, std::span<const std::byte> datagram) {
  const sensor::Protocol& language = *protocols_[protocol];
  const std::optional<unsigned> version = language.unknown_version(datagram);
  if (!version) return;
  const auto known = std::ranges::find_if(unknown_versions_, [&](const Report::UnknownVersion& one) {
    return one.version == *version && one.protocol == language.name();
  });
  if (known != unknown_versions_.end())
    ++known->count;
  else if (unknown_versions_.size() < kMostVersions)
    unknown_versions_.push_back({.protocol = std::string(language.name()),
                                 .version = *version,
                                 .source = std::string(sender.source),
                                 .count = 1});
}

Receiver::Received Receiver::reject_malformed(sensor::Peer peer) {
  ++malformed_;
  for (const Device& known : devices_)
    if (known.peer == peer && known.sensor) links_[*known.sensor].health.add_malformed();
  Received out;
  out.verdict = Verdict::malformed;
  return out;
}

Receiver::Received Receiver::receive(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                                     std::span<const std::byte> payload, SampleConsumer& consumer) {
  const std::size_t protocol = protocol_of(datagram);
  sensor::Reducer* const reducer = protocol < reducers_.size() ? reducers_[protocol].get() : nullptr;
  if (payload.empty() || payload.size() > sensor::kMaxPayload || reducer == nullptr)
    return decode(arrival, sender, protocol, datagram, {payload, {}}, Origin::device, consumer);
  const std::optional<std::size_t> length = reducer->reduce(datagram, payload, reduction_);
  if (!length || *length == 0 || *length > reduction_.size()) return reject_malformed(sender.peer);
  reduced_by_ = reducer->hash();
  return decode(arrival, sender, protocol, datagram, {std::span(reduction_).first(*length), reduced_by_},
                Origin::device, consumer);
}

Receiver::Received Receiver::receive_logged(HostTime arrival, Sender sender,
                                            std::span<const std::byte> datagram,
                                            const sensor::Payload& payload, SampleConsumer& consumer) {
  return decode(arrival, sender, protocol_of(datagram), datagram, payload, Origin::log, consumer);
}

bool Receiver::brings_unwanted_sound(const sensor::Inbox& inbox) const {
  return std::ranges::any_of(inbox.readings, [&](const sensor::Reading& reading) {
    if (reading.sample.kind != sensor::SampleKind::sound) return false;
    const auto bound = std::ranges::find(bound_, reading.from, &std::pair<DeviceKey, std::uint16_t>::first);
    return !listens_ || bound == bound_.end() ||
           rig_.sensors[bound->second].kind != shaping::Merge::kListening;
  });
}

Receiver::Received Receiver::decode(HostTime arrival, Sender sender, std::size_t protocol,
                                    std::span<const std::byte> datagram, const sensor::Payload& payload,
                                    Origin origin, SampleConsumer& consumer) {
  const sensor::Peer peer = sender.peer;
  if (protocol >= protocols_.size() || payload.bytes.size() > sensor::kMaxPayload)
    return reject_malformed(peer);
  inbox_.clear();
  samples_.clear();
  Received out;
  out.log = datagram;
  out.payload = payload;
  sensor::Protocol& language = *protocols_[protocol];
  out.verdict = payload.bytes.empty()
                    ? language.receive(arrival, peer, datagram, inbox_)
                    : language.receive_with_payload(arrival, peer, datagram, payload.bytes, inbox_);
  if (out.verdict != Verdict::taken) note_version(protocol, sender, datagram);
  if (out.verdict == Verdict::malformed) return reject_malformed(peer);
  // What no device measures, no device sends.
  if (origin == Origin::device && std::ranges::any_of(inbox_.readings, [](const sensor::Reading& reading) {
        return reading.sample.kind == sensor::SampleKind::imu_head_relative;
      }))
    out.verdict = Verdict::refused;
  if (out.verdict == Verdict::refused) {
    ++refused_;
    return out;
  }
  if (brings_unwanted_sound(inbox_)) {
    out.verdict = Verdict::ignored;
    out.log = {};
    out.payload = {};
    return out;
  }
  for (const sensor::Announcement& announced : inbox_.announcements) {
    Device* const from = &meet(announced.from, sender, protocol, arrival);
    from->announces = announced.site;
    const auto sensor = rig_.find(announced.site);
    const bool taken =
        sensor && std::ranges::any_of(bound_, [&](const auto& b) { return b.second == *sensor; });
    if (sensor && !taken && !from->sensor) bind(*sensor, announced.from, consumer);
  }
  if (inbox_.no_face) {
    const Device& from = meet(*inbox_.no_face, sender, protocol, arrival);
    if (from.sensor && from.peer == peer) {
      links_[*from.sensor].said_no_face = true;
      links_[*from.sensor].health.add_no_face(arrival);
    }
  }
  for (const sensor::Reading& reading : inbox_.readings)
    take_reading(arrival, sender, protocol, reading, consumer);
  for (const sensor::Inbox::Pulse& pulse : inbox_.pulses) {
    // A board's sensors share its clock.
    for (const auto& [key, sensor] : bound_)
      if (key.device == pulse.from.device && speaks_from(key, peer))
        ticks_.pulse(sensor, pulse.index, pulse.edge);
  }
  for (const sensor::Inbox::Battery& battery : inbox_.batteries)
    if (const Device* from = find(battery.from); from != nullptr && from->sensor && from->peer == peer)
      links_[*from->sensor].health.set_battery(battery.percent);
  // A board that sends anything at all is alive, whichever of its sensors it is about.
  const std::optional<DeviceKey> speaker =
      !inbox_.readings.empty() ? std::optional(inbox_.readings.front().from) : inbox_.alive;
  if (speaker)
    for (Device& known : devices_) {
      if (known.key.device != speaker->device || known.peer != peer) continue;
      known.alive = arrival;
      if (known.sensor) links_[*known.sensor].health.add_alive(arrival);
    }
  if (inbox_.recentre) consumer.asked_to_recentre(arrival, sender.source);
  out.samples = samples_;
  if (!inbox_.opened.empty()) out.log = inbox_.opened;
  out.reply = inbox_.reply;
  return out;
}

void Receiver::heartbeats(HostTime now, std::vector<sensor::Protocol::Outgoing>& out) {
  for (const auto& protocol : protocols_) protocol->heartbeats(now, out);
}

void Receiver::watch_links(HostTime fired, const std::function<void(std::uint16_t, LinkChange)>& changed) {
  for (std::uint16_t i = 0; i < links_.size(); ++i) {
    Link& link = links_[i];
    if (!link.received && !link.said_no_face) continue;
    const bool no_face = link.health.sees_no_face(fired);
    const bool silent = !link.received || fired - *link.received > (link.estimated ? kLostEstimated : kLost);
    const bool lost = silent && !no_face;
    if (lost != link.lost) {
      link.lost = lost;
      changed(i, lost ? LinkChange::lost : LinkChange::back);
    }
    if (lost || no_face == link.no_face) continue;
    link.no_face = no_face;
    changed(i, no_face ? LinkChange::face_lost : LinkChange::face_back);
  }
}

void Receiver::report_senders(HostTime now, const DeviceKey& key, Report::Link& out) const {
  out.source.clear();
  out.rivals.clear();
  const Device* const device = find(key);
  if (device == nullptr) return;
  out.source = device->source;
  for (const Rival& rival : device->rivals)
    if (rival.received && now - *rival.received < kContest)
      out.rivals.push_back({rival.source, now - *rival.received, rival.plausibility.is_implausible()});
}

void Receiver::report(HostTime now, Report& out) const {
  out.malformed = malformed_;
  out.refused = refused_;
  out.unknown_versions = unknown_versions_;
  out.hold = ticks_.hold().now();
  out.longest_hold = ticks_.hold().longest();
  out.tap = tap_.armed();
  out.cover.sensor = cover_.armed();
  out.cover.trouble = cover_.trouble();
  out.links.resize(links_.size());
  for (std::uint16_t i = 0; i < links_.size(); ++i) {
    Report::Link& link = out.links[i];
    const auto bound = std::ranges::find(bound_, i, &std::pair<DeviceKey, std::uint16_t>::second);
    link.device = bound == bound_.end() ? std::string() : sensor::format_device(bound->first);
    std::optional<sensor::LinkClock> clock;
    const sensor::TimeLines& lines = ticks_.lines();
    if (links_[i].received && lines.clock(i).ready()) {
      const sensor::ClockModel& model = lines.clock(i);
      clock = sensor::LinkClock{
          .offset = model.to_host(links_[i].newest).time_since_epoch() - links_[i].newest.time_since_epoch(),
          .drift_ppm = 1e6 * model.rate(),
          .uncertainty = model.uncertainty(links_[i].newest)};
    }
    link.health = links_[i].health.report(now, clock);
    // No frame waits for a truth.
    if (link.health.state == sensor::LinkState::late && rig_.sensors[i].is_truth())
      link.health.state = sensor::LinkState::good;
    report_senders(now, bound == bound_.end() ? DeviceKey() : bound->first, link);
    // Two that send the same packets have no line of their own by which a link would tell them apart.
    if (!link.rivals.empty() && link.health.state == sensor::LinkState::good)
      link.health.state = sensor::LinkState::duplicate;
    if (bound == bound_.end()) link.health.state = sensor::LinkState::unbound;
    link.level = links_[i].level;
    link.view = views_[i];
  }
  out.unbound.clear();
  for (const Device& known : devices_)
    if (!known.sensor)
      out.unbound.push_back({sensor::format_device(known.key), known.announces,
                             std::string(protocols_[known.protocol]->name()), now - known.received,
                             known.source});
}

}  // namespace mien::session

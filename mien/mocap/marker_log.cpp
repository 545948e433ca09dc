#include "mien/mocap/marker_log.h"

#include <algorithm>

namespace mien::mocap {
namespace {

/// Most lists of names: bounds memory against hostile logs.
constexpr std::size_t kMaxLists = 64;
/// A clock that goes back by more than this is a restarted server.
constexpr double kRestartS = 1;

}  // namespace

bool MarkerLog::List::named() const {
  return !names.empty() && names.size() == count &&
         std::ranges::none_of(names, [](const std::string& name) { return name.empty(); });
}

void MarkerLog::add(HostTime arrival, std::span<const std::byte> datagram) {
  if (!is_marker_packet(datagram)) return;
  const auto packet = parse_marker_packet(datagram);
  if (!packet) return;
  const auto list_of = [&](std::uint64_t device, std::uint32_t id) -> List* {
    const std::pair key(device, id);
    if (!lists_.contains(key) && lists_.size() >= kMaxLists) return nullptr;
    return &lists_[key];
  };
  if (const auto* names = std::get_if<MarkerNamesPacket>(&*packet)) {
    List* list = list_of(names->device, names->list);
    if (list == nullptr) return;
    list->names.resize(names->markers);
    for (std::size_t i = 0; i < names->count; ++i) list->names[names->first + i] = names->names[i];
    return;
  }
  const auto& positions = std::get<MarkerPositionsPacket>(*packet);
  List* list = list_of(positions.device, positions.list);
  if (list == nullptr) return;
  const double time_s = to_seconds(positions.time.time_since_epoch());
  if (list->count == 0) list->count = positions.count;
  if (positions.count != list->count) return;
  if (!list->run.time_s.empty() && time_s <= list->run.time_s.back()) {
    if (list->run.time_s.back() - time_s <= kRestartS || ended_.size() >= kMaxLists) return;
    ended_.push_back({{positions.device, positions.list}, std::move(list->run)});
    list->run = {};
  }
  list->run.time_s.push_back(time_s);
  list->run.position_m.insert(list->run.position_m.end(), positions.position_m.begin(),
                              positions.position_m.begin() + positions.count);
  list->run.arrival.push_back(arrival);
}

std::vector<MarkerLog::Received> MarkerLog::received() const {
  std::vector<Received> all;
  const auto add = [&](const Key& key, const Run& run) {
    const List& list = lists_.at(key);
    if (run.time_s.empty() || !list.named() || marker_list(list.names) != key.second) return;
    Received& received = all.emplace_back();
    received.device = key.first;
    received.track = {
        .name = "markers", .markers = list.names, .time_s = run.time_s, .position_m = run.position_m};
    received.arrival = run.arrival;
  };
  for (const auto& [key, run] : ended_) add(key, run);
  for (const auto& [key, list] : lists_) add(key, list.run);
  std::ranges::sort(all, [](const Received& a, const Received& b) {
    return a.arrival.size() != b.arrival.size() ? a.arrival.size() > b.arrival.size()
           : a.device != b.device               ? a.device < b.device
                                                : a.arrival < b.arrival;
  });
  return all;
}

std::size_t MarkerLog::unnamed() const {
  std::size_t frames = 0;
  const auto add = [&](const Key& key, const Run& run) {
    const List& list = lists_.at(key);
    if (!list.named() || marker_list(list.names) != key.second) frames += run.time_s.size();
  };
  for (const auto& [key, run] : ended_) add(key, run);
  for (const auto& [key, list] : lists_) add(key, list.run);
  return frames;
}

}  // namespace mien::mocap

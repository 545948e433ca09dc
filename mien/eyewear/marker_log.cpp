#include "mien/eyewear/marker_log.h"

#include <algorithm>

namespace mien::eyewear {
namespace {

/// A log cannot hold more lists of names than a session has servers, within reason.
constexpr std::size_t kMaxLists = 64;

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
  if (positions.count != list->count || (!list->time_s.empty() && time_s <= list->time_s.back())) return;
  list->time_s.push_back(time_s);
  list->position_m.insert(list->position_m.end(), positions.position_m.begin(),
                          positions.position_m.begin() + positions.count);
  list->arrival.push_back(arrival);
}

std::vector<MarkerLog::Heard> MarkerLog::heard() const {
  std::vector<Heard> all;
  for (const auto& [key, list] : lists_) {
    if (!list.named() || marker_list(list.names) != key.second) continue;
    Heard& heard = all.emplace_back();
    heard.device = key.first;
    heard.track = {
        .name = "markers", .markers = list.names, .time_s = list.time_s, .position_m = list.position_m};
    heard.arrival = list.arrival;
  }
  std::ranges::sort(all, [](const Heard& a, const Heard& b) {
    return a.arrival.size() != b.arrival.size() ? a.arrival.size() > b.arrival.size() : a.device < b.device;
  });
  return all;
}

std::size_t MarkerLog::unnamed() const {
  std::size_t frames = 0;
  for (const auto& [key, list] : lists_)
    if (!list.named() || marker_list(list.names) != key.second) frames += list.time_s.size();
  return frames;
}

}  // namespace mien::eyewear

#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mien/core/time.h"

namespace mien::sensor {

/// When who is new takes the place, and the device's number, of a sender that is silent.
enum class TakesPlace : std::uint8_t {
  at_once,    ///< Before a place of its own: a program that starts anew is its old self by another key.
  when_full,  ///< When there is no other: keys are ids that stay.
};

/// Senders without a MAC on the wire, each known by a key (where it sends from, or an id of its own): the
/// device's number of each counts from `first_device` in the order in which they were first heard. A sender
/// is silent after two seconds. A pure function of the calls. No allocation but for keys' own.
template <class Key, class State>
class SenderPlaces {
 public:
  struct Place {
    Key key{};
    std::uint64_t device = 0;
    HostTime heard;
    State state{};
  };

  SenderPlaces(std::uint64_t first_device, std::size_t most, TakesPlace takes)
      : first_device_(first_device), most_(most), takes_(takes) {
    places_.reserve(most);
  }

  /// The place of this sender, now heard, and its own from now on if it is new; null: all are taken. Valid
  /// until the next call.
  template <class Named>
  [[nodiscard]] Place* meet(const Named& key, HostTime arrival) {
    const auto known = std::ranges::find(places_, key, &Place::key);
    if (known != places_.end()) {
      known->heard = arrival;
      return &*known;
    }
    Place made{.key = Key(key), .device = first_device_ + places_.size(), .heard = arrival};
    const bool room = places_.size() < most_;
    if (!room || takes_ == TakesPlace::at_once) {
      const auto silent = std::ranges::min_element(places_, {}, &Place::heard);
      if (silent != places_.end() && arrival - silent->heard > kSilent) {
        made.device = silent->device;
        *silent = std::move(made);
        return &*silent;
      }
    }
    return room ? &places_.emplace_back(std::move(made)) : nullptr;
  }

 private:
  static constexpr Duration kSilent = std::chrono::seconds(2);

  std::uint64_t first_device_;
  std::size_t most_;
  TakesPlace takes_;
  std::vector<Place> places_;
};

}  // namespace mien::sensor

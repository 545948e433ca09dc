#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include "mien/take/take.h"

namespace mien::take {

/// The log entry that something came with or from: its place in the session's order.
[[nodiscard]] inline std::int64_t place_in_log(const LogEntry& entry) {
  return entry.id;
}
[[nodiscard]] inline std::int64_t place_in_log(const StoredSample& sample) {
  return sample.entry;
}

/// One thing that happens next: an item or a tick, never both.
template <class Item>
struct ReplayStep {
  const Item* item = nullptr;
  const Tick* tick = nullptr;
};

/// A session's order, again: every item (log entry or decoded sample), and after the last item that was known
/// when a tick fired, that tick. `for (const auto& step : replay_order(samples, ticks))`.
///
/// Entries decoded one by one as they come and the samples stored beside them give the same sequence of
/// samples and ticks. Shape: items in the order of place_in_log(), ticks in the order of after_entry; Take's
/// readers hold to both. Lifetime: looks at the spans, owns nothing. No allocation.
template <class Item>
class ReplayOrder {
 public:
  ReplayOrder(std::span<const Item> items, std::span<const Tick> ticks) : items_(items), ticks_(ticks) {}

  class Iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using value_type = ReplayStep<Item>;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    explicit Iterator(const ReplayOrder& order) : items_(order.items_), ticks_(order.ticks_) { advance(); }

    const ReplayStep<Item>& operator*() const { return step_; }
    const ReplayStep<Item>* operator->() const { return &step_; }
    Iterator& operator++() {
      advance();
      return *this;
    }
    void operator++(int) { advance(); }
    friend bool operator==(const Iterator& it, std::default_sentinel_t) {
      return it.step_.item == nullptr && it.step_.tick == nullptr;
    }

   private:
    void advance() {
      step_ = {};
      const bool tick_is_due =
          !ticks_.empty() && (items_.empty() || ticks_.front().after_entry < place_in_log(items_.front()));
      if (tick_is_due) {
        step_.tick = &ticks_.front();
        ticks_ = ticks_.subspan(1);
      } else if (!items_.empty()) {
        step_.item = &items_.front();
        items_ = items_.subspan(1);
      }
    }

    std::span<const Item> items_;  // What is still to come.
    std::span<const Tick> ticks_;
    ReplayStep<Item> step_;
  };

  [[nodiscard]] Iterator begin() const { return Iterator(*this); }
  [[nodiscard]] std::default_sentinel_t end() const { return {}; }

 private:
  std::span<const Item> items_;
  std::span<const Tick> ticks_;
};

/// Of raw packets: `mien solve` and replays receive them again through session::Receiver (`--from-log` of
/// `mien solve` changes nothing).
[[nodiscard]] inline ReplayOrder<LogEntry> replay_order(std::span<const LogEntry> entries,
                                                        std::span<const Tick> ticks) {
  return {entries, ticks};
}
/// Of decoded samples: virtual performers are calibrated from their own.
[[nodiscard]] inline ReplayOrder<StoredSample> replay_order(std::span<const StoredSample> samples,
                                                            std::span<const Tick> ticks) {
  return {samples, ticks};
}

}  // namespace mien::take

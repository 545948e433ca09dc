#pragma once

#include "mien/core/time.h"

namespace mien::live {

/// Wakes one thread from another, through a file descriptor that an event loop can wait for too. Signals
/// given while nobody waits are kept as one. No allocation, no lock.
class Signal {
 public:
  /// Throws std::system_error when the machine gives no descriptor.
  Signal();
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  /// Any thread.
  void give();
  /// Returns when a signal is there, or after `at_most`; a signal is then taken. Negative: at once.
  void wait(Duration at_most);
  /// Takes what is there, without waiting.
  void take();
  /// Readable while a signal is there.
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace mien::live

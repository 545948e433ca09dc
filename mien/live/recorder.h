#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "mien/core/error.h"
#include "mien/live/byte_ring.h"
#include "mien/live/signal.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/ticks.h"
#include "mien/take/take.h"

namespace mien::live {

/// Writes a session's log into takes, on a thread of its own: the tracker's thread hands over and goes on,
/// whatever the disk does. A take begins with the session's beginning, whenever its recording was asked for:
/// what came before is kept in a temporary file, so that every take replays to what was seen.
class Recorder {
 public:
  /// `peer_name` tells a peer's source text; called on the recorder's thread for peers already seen.
  explicit Recorder(std::function<std::string(sensor::Peer)> peer_name);
  ~Recorder();  ///< As stop().

  // Tracker's thread. What does not fit any more is lost to the recording, which then ends with an error.
  void entry(HostTime arrival, sensor::Peer peer, std::span<const std::byte> bytes,
             std::span<const sensor::Sample> samples);
  void command(HostTime arrival, std::string_view json);
  void tick(const sensor::FrameTick& tick);
  void event(const take::Event& event);
  void calibration(std::int64_t id, DeviceTime made, std::string_view modality, std::string_view json);

  // Any thread.
  /// Errors: bad_usage (a recording runs, the file exists and not `replace`), io; those of TakeWriter.
  [[nodiscard]] Result<void> start(const std::filesystem::path& path, const take::Header& header,
                                   bool replace);
  /// Ends the recording with notes; everything is on the disk when this returns. Nothing happens when none
  /// runs. Errors: what went wrong while recording.
  [[nodiscard]] Result<void> finish(std::span<const take::Note> notes);

  struct State {
    bool on = false;
    std::filesystem::path path;
    double seconds = 0;  ///< Of the session, in the take.
    std::string error;   ///< Why a recording ended early; empty when none did.
  };
  [[nodiscard]] State state() const;

 private:
  struct Writing;
  enum class Kind : std::uint8_t { entry, command, tick, event, calibration };
  std::span<std::byte> claim(std::size_t size);
  void run();
  bool drain();
  void keep(std::span<const std::byte> record);
  void write(std::span<const std::byte> record);
  void fail_recording(const std::string& why);

  std::function<std::string(sensor::Peer)> peer_name_;
  ByteRing ring_;
  Signal signal_;
  std::atomic<bool> overrun_ = false;
  std::atomic<bool> stopping_ = false;

  mutable std::mutex mutex_;  // Of what follows; never taken by the tracker's thread.
  std::unique_ptr<Writing> writing_;
  State state_;
  std::FILE* spool_ = nullptr;
  std::uint64_t spooled_ = 0;  // Bytes.
  std::string spool_error_;
  std::thread thread_;
};

}  // namespace mien::live

#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/time.h"

namespace mien::live {

/// The temporary log of a session: what a take begins with, whenever it is asked for. Two files without a
/// name that are gone with this: one of records, one of payloads. Together they take no more than the limit,
/// and payloads no more than half of it, so that pictures never crowd out what is small. Thread: one at a
/// time.
class Spool {
 public:
  /// Three hours and twenty minutes of twelve sensors at 240 Hz. Bytes.
  static constexpr std::uint64_t kDefaultLimit = 4'000'000'000;

  /// The files stand in `folder` (empty: the present one), whose file system has to have room for `limit`
  /// bytes. Where it takes none, is_open() is false and problem() gives the reason.
  Spool(std::filesystem::path folder, std::uint64_t limit);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  [[nodiscard]] bool is_open() const { return log_.file != nullptr; }
  /// Why the folder took no file when this was made; empty when it did.
  [[nodiscard]] const std::string& problem() const { return problem_; }

  /// Appends a record with its size before it, 32 bits. Errors: io (the limit is reached, the disk is full).
  [[nodiscard]] Result<void> append(std::span<const std::byte> record);
  /// Appends a payload, nothing before it: who reads knows its length from the record that it belongs to.
  /// Errors: io, as append().
  [[nodiscard]] Result<void> append_payload(std::span<const std::byte> payload);
  /// Up to out.size() bytes from `at` on, of records or of payloads, as many as there are. Errors: io.
  [[nodiscard]] Result<std::size_t> read(std::uint64_t at, std::span<std::byte> out);
  [[nodiscard]] Result<std::size_t> read_payloads(std::uint64_t at, std::span<std::byte> out);
  /// A log with a hole is good for nothing, and the disk may be full: gives its room back.
  void close();

  /// What it takes, bytes.
  struct Usage {
    std::uint64_t bytes = 0;  ///< Records and payloads together.
    std::uint64_t limit = 0;
    std::uint64_t payload_bytes = 0;
    std::uint64_t payload_limit = 0;
    /// Until one of the limits is reached at the rate of the last ten to twenty seconds; none in the first
    /// second, and when it is closed.
    std::optional<double> seconds_left;
  };
  /// `now`: the newest moment of what was appended, which the rate goes by.
  [[nodiscard]] Usage usage(HostTime now);
  [[nodiscard]] std::uint64_t bytes() const { return log_.bytes; }

 private:
  struct File {
    std::FILE* file = nullptr;
    std::uint64_t bytes = 0;
  };
  struct Mark {
    HostTime at;
    std::uint64_t bytes = 0;
    std::uint64_t payload_bytes = 0;
  };
  [[nodiscard]] Result<void> write(File& to, std::span<const std::byte> bytes);
  [[nodiscard]] Result<std::size_t> read(const File& from, std::uint64_t at, std::span<std::byte> out);
  [[nodiscard]] std::string no_room() const;
  [[nodiscard]] std::unexpected<Error> full(std::string_view what) const;

  std::filesystem::path folder_;
  std::uint64_t limit_;
  File log_;
  File payloads_;  // Opened with the first.
  std::string problem_;
  Mark older_, newer_;
};

}  // namespace mien::live

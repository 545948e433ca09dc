// Any bytes as a take: opened and read from end to end. Where the bytes hold the magic of a rollback journal,
// what follows it stands beside the take as its journal, so recovery is reached too; where they begin with
// it, the take is a sound one.

#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "mien/take/summary.h"

namespace {

/// In memory where the machine has such a folder, as are the copies that recovery makes: a disk that stalls
/// would look like an input that hangs.
const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const std::filesystem::path shared = "/dev/shm";
    std::string name =
        ((std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path()) /
         "take-fuzz-XXXXXX")
            .string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    if (::setenv("TMPDIR", name.c_str(), 1) != 0) std::abort();
    static std::string kept = name;
    std::atexit([] { std::filesystem::remove_all(kept); });
    return name;
  }();
  return path;
}

void write(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// The bytes of a small take.
const std::vector<std::uint8_t>& sound_take() {
  static const std::vector<std::uint8_t> take = [] {
    const auto path = folder() / "sound";
    mien::take::Header header;
    header.rig_toml =
        "name=\"r\"\nreference=\"a\"\n[[sensor]]\nname=\"a\"\nkind=\"imu\"\nsite=\"mastoid\"\nside="
        "\"L\"\nrole=\"head\"\n";
    auto writer = mien::take::TakeWriter::create(path, header, true);
    if (!writer) std::abort();
    const std::array<std::byte, 3> payload{};
    writer->add_entry({}, "udp", {}, {payload, {}});
    writer->add_truth({});
    if (!writer->finish()) std::abort();
    std::ifstream file(path, std::ios::binary);
    return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(file), {});
  }();
  return take;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array<std::uint8_t, 8> kJournalMagic = {0xD9, 0xD5, 0x05, 0xF9, 0x20, 0xA1, 0x63, 0xD7};
  const std::span<const std::uint8_t> bytes(data, size);
  const auto journal = std::search(bytes.begin(), bytes.end(), kJournalMagic.begin(), kJournalMagic.end());
  const auto file_size = static_cast<std::size_t>(journal - bytes.begin());
  const auto path = folder() / "take";
  const auto journal_path = folder() / "take-journal";
  write(path,
        file_size == 0 && size > 0 ? std::span<const std::uint8_t>(sound_take()) : bytes.first(file_size));
  if (file_size < size)
    write(journal_path, bytes.subspan(file_size));
  else
    std::filesystem::remove(journal_path);

  const auto take = mien::take::Take::open(path);
  if (!take) {
    if (take.error().message().find('\n') != std::string::npos) std::abort();
    return 0;
  }
  // What a take gives out must be usable without another look.
  const auto entries = take->entries();
  const auto samples = take->samples();
  const auto ticks = take->ticks();
  if (entries && ticks)
    for (std::size_t i = 0; i < ticks->size(); ++i)
      if ((*ticks)[i].after_entry > std::ssize(*entries) ||
          (i > 0 && (*ticks)[i].after_entry < (*ticks)[i - 1].after_entry))
        std::abort();
  if (auto payloads = take->payloads(); payloads && entries)
    for (const auto& entry : *entries) {
      const auto payload = payloads->of(entry.id);
      if (!payload) break;
      if (payload->bytes.size() > mien::sensor::kMaxPayload ||
          (!payload->reducer.empty() && !mien::sensor::is_reducer_hash(payload->reducer)))
        std::abort();
    }
  if (samples)
    for (const auto& stored : *samples)
      if (stored.sample.sensor >= take->rig().sensors.size() ||
          stored.sample.count > stored.sample.values.size())
        std::abort();
  static_cast<void>(take->truth());
  static_cast<void>(take->events());
  static_cast<void>(take->calibrations());
  static_cast<void>(take->audio());
  static_cast<void>(take->notes());
  static_cast<void>(mien::take::summarise(*take));
  static_cast<void>(take->check());
  return 0;
}

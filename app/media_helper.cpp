#include "app/media_helper.h"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"

namespace mien::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelper = "mien-media";

Result<Child> start_helper(std::vector<std::string> arguments, Child::Output output = Child::Output::kept) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper(kHelper));
  arguments.insert(arguments.begin(), helper.string());
  auto child = Child::start(std::move(arguments), Child::Input::fed, {}, output);
  if (!child) child.error().fix = "build or install it again";
  return child;
}

/// Waits for its end. `broke_off`: it stopped listening too early, which is an error even if it claims none.
Result<void> finish_helper(Child& child, bool broke_off = false) {
  MIEN_TRY_ASSIGN(const ChildOutput output, child.wait());
  if (output.succeeded() && !broke_off) return {};
  std::string said = output.complaints.substr(0, output.complaints.find('\n'));
  const std::string prefix = fmt::format("{}: ", kHelper);
  if (said.starts_with(prefix)) said.erase(0, prefix.size());
  const bool bad_input = output.status == 2;
  // The loader's own exit status when a shared library is missing.
  const bool incomplete = output.status == 127;
  return fail(bad_input ? ErrorCode::bad_usage : ErrorCode::io,
              said.empty() ? "it stopped without a word" : said, kHelper,
              incomplete
                  ? "install Debian's libavformat59, libswscale6, libswresample4, libespeak-ng1 and libflite1"
                  : "");
}

/// The line before what a helper writes, without its end.
Result<std::string> read_head(Child& child) {
  constexpr std::size_t kLongestHead = 100;
  std::string head;
  std::array<std::uint8_t, 1> one{};
  while (head.size() < kLongestHead) {
    MIEN_TRY_ASSIGN(const std::size_t got, child.receive(one));
    if (got == 0 || one[0] == '\n') break;
    head += static_cast<char>(one[0]);
  }
  return head;
}

}  // namespace

Result<FilmWriter> FilmWriter::start(const fs::path& out, int width, int height, double rate_hz,
                                     const std::optional<Sound>& sound) {
  std::vector<std::string> arguments = {
      "video", "--size",    fmt::format("{}x{}", width, height), "--fps", fmt::format("{}", rate_hz),
      "--out", out.string()};
  std::optional<PrivateFolder> folder;
  if (sound && !sound->samples.empty()) {
    MIEN_TRY_ASSIGN(folder, PrivateFolder::make());
    const fs::path wav = folder->path() / "sound.wav";
    MIEN_TRY(write_file(wav, format_wav(*sound)));
    arguments.insert(arguments.end(), {"--audio", wav.string()});
  }
  MIEN_TRY_ASSIGN(Child child, start_helper(std::move(arguments)));
  return FilmWriter(std::move(child), std::move(folder), width, height);
}

Result<void> FilmWriter::add_frame(const render::Image& frame) {
  if (frame.width != width_ || frame.height != height_)
    return fail(ErrorCode::mismatch, fmt::format("a frame of {} x {}", frame.width, frame.height),
                "the film");
  return child_.send(frame.rgb) ? Result<void>() : finish_helper(child_, true);
}

Result<void> FilmWriter::finish() {
  return finish_helper(child_);
}

Result<FilmReader> FilmReader::start(const fs::path& film, int most_width, int most_height) {
  MIEN_TRY_ASSIGN(
      Child child,
      start_helper({"frames", "--most", fmt::format("{}x{}", most_width, most_height), "--", film.string()},
                   Child::Output::read));
  FilmReader reader(std::move(child));
  MIEN_TRY_ASSIGN(const std::string head, read_head(reader.child_));
  if (std::sscanf(head.c_str(), "grey %5dx%5d %12zu", &reader.width_, &reader.height_, &reader.about_) != 3 ||
      reader.width_ < 1 || reader.height_ < 1 || reader.width_ > most_width || reader.height_ > most_height) {
    MIEN_TRY(finish_helper(reader.child_, true));
    return fail(ErrorCode::internal, "it tells no size of the film's pictures", kHelper);
  }
  return reader;
}

Result<bool> FilmReader::next(std::span<std::uint8_t> grey) {
  if (grey.size() != static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_))
    return fail(ErrorCode::mismatch, fmt::format("a picture of {} pixels", grey.size()), "the film");
  MIEN_TRY_ASSIGN(const std::size_t got, child_.receive(grey));
  if (got == grey.size()) return true;
  MIEN_TRY(finish_helper(child_, got > 0));
  return false;
}

Result<solve::FilmSound> read_film_sound(const fs::path& film, int rate_hz) {
  MIEN_TRY_ASSIGN(Child child, start_helper({"sound", "--rate", std::to_string(rate_hz), "--", film.string()},
                                            Child::Output::read));
  MIEN_TRY_ASSIGN(const std::string head, read_head(child));
  int told_hz = 0;
  std::array<char, 32> timecode{};
  double timecode_hz = 0;
  if (std::sscanf(head.c_str(), "sound %7d %31s %9lf", &told_hz, timecode.data(), &timecode_hz) != 3 ||
      told_hz != rate_hz) {
    MIEN_TRY(finish_helper(child, true));
    return fail(ErrorCode::internal, "it tells no rate of the film's sound", kHelper);
  }
  solve::FilmSound out;
  out.sound.rate_hz = static_cast<std::uint32_t>(rate_hz);
  if (const auto start = face::parse_timecode(timecode.data()); start && timecode_hz >= 1)
    out.start_s = face::timecode_seconds(*start, static_cast<int>(timecode_hz));
  std::vector<float> piece(std::size_t{1} << 16U);
  for (std::size_t got = piece.size(); got == piece.size();) {
    auto* const bytes = reinterpret_cast<std::uint8_t*>(piece.data());
    MIEN_TRY_ASSIGN(const std::size_t size, child.receive({bytes, piece.size() * sizeof(float)}));
    got = size / sizeof(float);
    out.sound.samples.insert(out.sound.samples.end(), piece.begin(),
                             piece.begin() + static_cast<std::ptrdiff_t>(got));
  }
  MIEN_TRY(finish_helper(child));
  return out;
}

performer::Speaker speaker_by_helper() {
  return [](const std::string& voice, const std::string& text,
            int words_per_minute) -> Result<performer::SpokenLine> {
    MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
    const fs::path json = folder.path() / "speech.json", wav = folder.path() / "speech.wav";
    MIEN_TRY_ASSIGN(Child child, start_helper({"speak", "--language=" + voice, "--text=" + text, "--rate",
                                               std::to_string(words_per_minute), "--json", json.string(),
                                               "--wav", wav.string()}));
    MIEN_TRY(finish_helper(child));
    performer::SpokenLine line;
    MIEN_TRY_ASSIGN(const std::string times, read_text(json));
    MIEN_TRY_ASSIGN(line.utterance, performer::parse_utterance(times));
    MIEN_TRY_ASSIGN(const auto bytes, read_file(wav));
    MIEN_TRY_ASSIGN(line.sound, parse_wav(bytes, "speech.wav"));
    return line;
  };
}

}  // namespace mien::app

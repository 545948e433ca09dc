#include "app/media_helper.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "app/child_program.h"
#include "app/private_folder.h"
#include "mien/core/files.h"

namespace mien::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelper = "mien-media";

Result<Child> start_helper(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper(kHelper));
  arguments.insert(arguments.begin(), helper.string());
  auto child = Child::start(std::move(arguments), Child::Input::fed);
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
              incomplete ? "install Debian's libavformat59, libswscale6, libespeak-ng1 and libflite1" : "");
}

}  // namespace

struct FilmWriter::State {
  State(Child started, int w, int h) : child(std::move(started)), width(w), height(h) {}
  std::optional<PrivateFolder> folder;  // Holds the sound; outlives the child.
  Child child;
  int width, height;
};

FilmWriter::FilmWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
FilmWriter::FilmWriter(FilmWriter&&) noexcept = default;
FilmWriter& FilmWriter::operator=(FilmWriter&&) noexcept = default;
FilmWriter::~FilmWriter() = default;

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
  auto state = std::make_unique<State>(std::move(child), width, height);
  state->folder = std::move(folder);
  return FilmWriter(std::move(state));
}

Result<void> FilmWriter::add_frame(const render::Image& frame) {
  if (frame.width != state_->width || frame.height != state_->height)
    return fail(ErrorCode::mismatch, fmt::format("a frame of {} x {}", frame.width, frame.height),
                "the film");
  return state_->child.send(frame.rgb) ? Result<void>() : finish_helper(state_->child, true);
}

Result<void> FilmWriter::finish() {
  return finish_helper(state_->child);
}

study::Speaker speaker_by_helper() {
  return [](const std::string& voice, const std::string& text,
            int words_per_minute) -> Result<study::SpokenLine> {
    MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
    const fs::path json = folder.path() / "speech.json", wav = folder.path() / "speech.wav";
    MIEN_TRY_ASSIGN(Child child, start_helper({"speak", "--language=" + voice, "--text=" + text, "--rate",
                                               std::to_string(words_per_minute), "--json", json.string(),
                                               "--wav", wav.string()}));
    MIEN_TRY(finish_helper(child));
    study::SpokenLine line;
    MIEN_TRY_ASSIGN(const std::string times, read_text(json));
    MIEN_TRY_ASSIGN(line.utterance, performer::parse_utterance(times));
    MIEN_TRY_ASSIGN(const auto bytes, read_file(wav));
    MIEN_TRY_ASSIGN(line.sound, parse_wav(bytes, "speech.wav"));
    return line;
  };
}

}  // namespace mien::app

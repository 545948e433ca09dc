#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "app/child_program.h"
#include "app/command.h"
#include "app/private_folder.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/media/festival_speech.h"
#include "mien/media/sound_reader.h"
#include "mien/media/speech_synthesis.h"
#include "mien/media/video_reader.h"
#include "mien/media/video_writer.h"

namespace {

using namespace mien;

struct VideoCommand {
  std::string size = "640x640", out, audio;
  double rate_hz = 30;
  int quality = 20;
};

volatile std::sig_atomic_t stop_asked = 0;

/// A stop ends what waits for input, so that what was begun is taken away again.
void catch_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_asked = 1; };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(signal, &action, nullptr);
}

/// "640x480", of the option that it stands in.
Result<void> parse_size(const std::string& text, const char* option, int& width, int& height) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &rest) == 2 && width > 0 && height > 0)
    return {};
  return fail(ErrorCode::bad_usage, fmt::format("'{}' is no size", text), option, "write it like 640x480");
}

/// Fills `frame` from standard input. True when there was a whole one, false at the end.
Result<bool> read_frame(std::span<std::uint8_t> frame) {
  std::size_t have = 0;
  while (have < frame.size()) {
    const ssize_t n = ::read(STDIN_FILENO, frame.data() + have, frame.size() - have);
    if (stop_asked != 0) return fail(ErrorCode::cancelled, "stopped", "standard input");
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::io, std::strerror(errno), "standard input");
    if (n == 0) break;
    have += static_cast<std::size_t>(n);
  }
  if (have == 0) return false;
  if (have < frame.size()) return fail(ErrorCode::truncated, "the last frame is cut short", "standard input");
  return true;
}

Result<void> run_video(const VideoCommand& command) {
  media::VideoOptions options;
  MIEN_TRY(parse_size(command.size, "--size", options.width, options.height));
  options.rate_hz = command.rate_hz;
  options.quality = command.quality;
  if (!command.audio.empty()) {
    MIEN_TRY_ASSIGN(const auto bytes, read_file(command.audio));
    MIEN_TRY_ASSIGN(options.sound, parse_wav(bytes, command.audio));
  }
  const std::size_t frame_size =
      std::size_t{3} * static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
  catch_signals();
  MIEN_TRY_ASSIGN(auto video, media::VideoWriter::create(command.out, std::move(options)));
  std::vector<std::uint8_t> frame(frame_size);
  for (;;) {
    MIEN_TRY_ASSIGN(const bool more, read_frame(frame));
    if (!more) return video.finish();
    MIEN_TRY(video.add_frame(frame));
  }
}

struct FramesCommand {
  std::string film, most = "1280x960";
};

Result<void> write_out(std::span<const std::byte> bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size()) return {};
  return fail(ErrorCode::io, std::strerror(errno), "standard output");
}

/// Writes a line, then all that the source has.
template <class Source>
Result<void> write_all(const std::string& head, Source& source, const std::string& where) {
  MIEN_TRY(write_out(std::as_bytes(std::span(head))));
  for (;;) {
    if (stop_asked != 0) return fail(ErrorCode::cancelled, "stopped", where);
    MIEN_TRY_ASSIGN(const auto piece, source.next());
    if (!piece) break;
    MIEN_TRY(write_out(std::as_bytes(std::span(*piece))));
  }
  if (std::fflush(stdout) != 0) return fail(ErrorCode::io, std::strerror(errno), "standard output");
  return {};
}

Result<void> run_frames(const FramesCommand& command) {
  int width = 0, height = 0;
  MIEN_TRY(parse_size(command.most, "--most", width, height));
  catch_signals();
  MIEN_TRY_ASSIGN(auto film, media::VideoReader::open(command.film, width, height));
  return write_all(fmt::format("grey {}x{} {}\n", film.width(), film.height(), film.about()), film,
                   command.film);
}

struct SoundCommand {
  std::string film;
  int rate_hz = 16'000;
};

Result<void> run_sound(const SoundCommand& command) {
  catch_signals();
  MIEN_TRY_ASSIGN(auto film, media::SoundReader::open(command.film, command.rate_hz));
  const auto& start = film.start();
  const std::string head =
      fmt::format("sound {} {} {}\n", command.rate_hz, start ? face::format_timecode(start->timecode) : "-",
                  start ? start->rate_hz : 0);
  return write_all(head, film, command.film);
}

struct SpeakCommand {
  std::string language = "en-us", text, json, wav;
  int words_per_minute = 175;
};

/// By festival, which is a program of its own.
Result<media::SpokenText> speak_by_festival(const std::string& voice, const std::string& text,
                                            int words_per_minute) {
  const std::string where = "festival's " + voice;
  constexpr const char* kFix = "install Debian's packages of script/packages/voices.txt";
  MIEN_TRY_ASSIGN(const app::PrivateFolder folder, app::PrivateFolder::make());
  const std::filesystem::path script = folder.path() / "script.scm", wav = folder.path() / "sound.wav";
  MIEN_TRY_ASSIGN(const std::string said, media::festival_script(voice, text, words_per_minute, wav));
  MIEN_TRY(write_file(script, said));
  auto output = app::run_child({"festival", "-b", script.string()});
  if (!output) {
    output.error().fix = kFix;
    return std::unexpected(output.error());
  }
  std::error_code none;
  if (!output->succeeded() || !std::filesystem::exists(wav, none))
    return fail(ErrorCode::io,
                fmt::format("it does not read '{}': {}", excerpt(text),
                            excerpt(output->complaints.substr(0, output->complaints.find('\n')))),
                where, kFix);
  media::SpokenText spoken;
  MIEN_TRY_ASSIGN(const auto bytes, read_file(wav));
  MIEN_TRY_ASSIGN(spoken.sound, parse_wav(bytes, where));
  MIEN_TRY_ASSIGN(spoken.phonemes, media::parse_festival_phones(output->out, voice));
  return spoken;
}

Result<media::SpokenText> speak(const SpeakCommand& command) {
  if (!command.language.starts_with(media::kFestivalPrefix))
    return media::speak(command.language, command.text, command.words_per_minute);
  return speak_by_festival(command.language.substr(media::kFestivalPrefix.size()), command.text,
                           command.words_per_minute);
}

Result<void> run_speak(const SpeakCommand& command) {
  MIEN_TRY_ASSIGN(const auto spoken, speak(command));
  if (!command.wav.empty()) MIEN_TRY(write_file(command.wav, format_wav(spoken.sound)));
  const std::string json =
      media::spoken_text_json(command.language, command.text, command.words_per_minute, spoken);
  if (!command.json.empty()) return write_file(command.json, json);
  std::fputs(json.c_str(), stdout);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  app::Commands commands("mien-media", "mien-media: what mien needs FFmpeg and espeak-ng for");
  commands.require_one(true);

  VideoCommand video;
  const app::Command video_command =
      commands.add("video", "Raw RGB frames on standard input become an MP4",
                   "mien-media video --size 640x480 --fps 30 --out face.mp4 < frames.rgb",
                   [&] { return run_video(video); });
  video_command.add_option("--size", video.size, "Width x height in pixels, even").required();
  video_command.add_option("--fps", video.rate_hz, "Frames a second").show_default();
  video_command
      .add_option("--quality", video.quality, "H.264's constant rate factor, 0 to 51; lower is better")
      .show_default();
  video_command.add_option("--audio", video.audio, "A WAV file to play along");
  video_command.add_option("--out", video.out, "The file to write").required();

  FramesCommand frames;
  const app::Command frames_command = commands.add(
      "frames",
      "Writes a film's pictures to standard output: a line 'grey WIDTHxHEIGHT ABOUT', then each in grey, a "
      "byte a pixel, row by row",
      "mien-media frames face.mp4 > face.grey", [&] { return run_frames(frames); });
  frames_command.add_option("film", frames.film, "The film").required();
  frames_command.add_option("--most", frames.most, "Width x height beyond which pictures are made smaller")
      .show_default();

  SoundCommand sound;
  const app::Command sound_command =
      commands.add("sound",
                   "Writes a film's sound to standard output: a line 'sound RATE TIMECODE RATE_OF_THAT' (- "
                   "and 0 where the "
                   "film has none), then one channel of 32-bit floats of this machine's byte order, from its "
                   "first picture "
                   "on",
                   "mien-media sound face.mov > face.f32", [&] { return run_sound(sound); });
  sound_command.add_option("film", sound.film, "The film, or a sound: M4A, WAV").required();
  sound_command.add_option("--rate", sound.rate_hz, "Samples a second").show_default();

  SpeakCommand speak;
  const app::Command speak_command =
      commands.add("speak", "Reads a text aloud; prints when each phoneme is spoken",
                   "mien-media speak --language de --text 'Guten Tag' --json tag.json --wav tag.wav",
                   [&] { return run_speak(speak); });
  speak_command
      .add_option("--language", speak.language,
                  "As espeak-ng names it: en-us, de, fr-fr, es, de+f3; or a voice of flite or festival: "
                  "flite:slt, festival:czech_dita")
      .show_default();
  speak_command.add_option("--text", speak.text, "What to say").required();
  speak_command.add_option("--rate", speak.words_per_minute, "Words a minute, 80 to 450").show_default();
  speak_command.add_option("--json", speak.json, "Where the times go; standard output unless told");
  speak_command.add_option("--wav", speak.wav, "Where the sound goes");
  return commands.main(argc, argv, app::plain_usage_error);
}

#include "app/media_helper.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "app/private_folder.h"
#include "mien/core/files.h"

extern char** environ;

namespace mien::app {
namespace fs = std::filesystem;
namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int value = -1) : value_(value) {}
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close() {
    if (value_ >= 0) ::close(std::exchange(value_, -1));
  }
  [[nodiscard]] int get() const { return value_; }

 private:
  int value_;
};

/// A helper at work: we feed its standard input and keep its complaints.
class Child {
 public:
  [[nodiscard]] static Result<Child> start(const fs::path& program,
                                           const std::vector<std::string>& arguments) {
    // A socket rather than a pipe: writing to a child that is gone then gives an error instead of a signal.
    std::array<int, 2> input{}, complaints{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, input.data()) != 0)
      return fail(ErrorCode::io, std::strerror(errno), program.string());
    Descriptor ours(input[0]), theirs(input[1]);
    if (::pipe2(complaints.data(), O_CLOEXEC) != 0)
      return fail(ErrorCode::io, std::strerror(errno), program.string());
    Descriptor read_end(complaints[0]), write_end(complaints[1]);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, theirs.get(), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, write_end.get(), STDERR_FILENO);
    std::string name = program.string();
    std::vector<std::string> words = arguments;
    std::vector<char*> argv = {name.data()};
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    Child child;
    child.name_ = program.filename().string();
    const int code = ::posix_spawn(&child.id_, name.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (code != 0) return fail(ErrorCode::io, std::strerror(code), name, "build or install it again");
    child.input_ = std::move(ours);
    child.complaints_ = std::move(read_end);
    return child;
  }
  Child(Child&& other) noexcept
      : id_(std::exchange(other.id_, -1)),
        name_(std::move(other.name_)),
        input_(std::move(other.input_)),
        complaints_(std::move(other.complaints_)) {}
  Child& operator=(Child&&) = delete;
  ~Child() {
    if (id_ <= 0) return;
    ::kill(id_, SIGTERM);
    input_.close();  // Whatever it waits for: it ends, and takes away what it began.
    ::waitpid(id_, nullptr, 0);
  }

  Result<void> send(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(input_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return finish(true);
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return {};
  }

  /// Ends its input and waits for it. `broke_off`: it stopped listening too early, which is an error even if
  /// it claims none.
  Result<void> finish(bool broke_off = false) {
    if (id_ <= 0) return fail(ErrorCode::io, "it has ended already", name_);
    input_.close();
    std::string said;
    std::array<char, 512> part{};
    for (;;) {
      const ssize_t n = ::read(complaints_.get(), part.data(), part.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      if (said.size() < 4096) said.append(part.data(), static_cast<std::size_t>(n));
    }
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && !broke_off) return {};
    said = said.substr(0, said.find('\n'));
    if (said.starts_with(name_ + ": ")) said.erase(0, name_.size() + 2);
    const bool bad_input = WIFEXITED(status) && WEXITSTATUS(status) == 2;
    // The loader's own exit status when a shared library is missing.
    const bool incomplete = WIFEXITED(status) && WEXITSTATUS(status) == 127;
    return fail(bad_input ? ErrorCode::bad_usage : ErrorCode::io,
                said.empty() ? "it stopped without a word" : said, name_,
                incomplete ? "install Debian's libavformat59, libswscale6 and libespeak-ng1" : "");
  }

 private:
  Child() = default;
  pid_t id_ = -1;
  std::string name_;
  Descriptor input_;
  Descriptor complaints_;
};

}  // namespace

Result<fs::path> find_helper(const std::string& name) {
  MIEN_TRY_ASSIGN(const fs::path self, running_program());
  std::error_code code;
  const fs::path path = self.parent_path() / name;
  if (!fs::exists(path, code))
    return fail(ErrorCode::not_found,
                fmt::format("the helper {} is not beside {}", name, self.filename().string()),
                self.parent_path().string(),
                name == "mien-media"
                    ? "build Mien with MIEN_MEDIA on; it needs Debian's libavformat-dev, libavcodec-dev, "
                      "libswscale-dev and libespeak-ng-dev"
                    : "build Mien with MIEN_TRAIN on; it needs Debian's libtorch-dev");
  return path;
}

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
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper("mien-media"));
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
  MIEN_TRY_ASSIGN(Child child, Child::start(helper, arguments));
  auto state = std::make_unique<State>(std::move(child), width, height);
  state->folder = std::move(folder);
  return FilmWriter(std::move(state));
}

Result<void> FilmWriter::add_frame(const render::Image& frame) {
  if (frame.width != state_->width || frame.height != state_->height)
    return fail(ErrorCode::mismatch, fmt::format("a frame of {} x {}", frame.width, frame.height),
                "the film");
  return state_->child.send(frame.rgb);
}

Result<void> FilmWriter::finish() {
  return state_->child.finish();
}

Result<HelperSpeech> speak_with_helper(const std::string& language, const std::string& text,
                                       int words_per_minute) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper("mien-media"));
  MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
  const fs::path json = folder.path() / "speech.json", wav = folder.path() / "speech.wav";
  MIEN_TRY_ASSIGN(Child child, Child::start(helper, {"speak", "--language=" + language, "--text=" + text,
                                                     "--rate", std::to_string(words_per_minute), "--json",
                                                     json.string(), "--wav", wav.string()}));
  MIEN_TRY(child.finish());
  HelperSpeech speech;
  MIEN_TRY_ASSIGN(speech.json, read_text(json));
  MIEN_TRY_ASSIGN(const auto bytes, read_file(wav));
  MIEN_TRY_ASSIGN(speech.sound, parse_wav(bytes, "speech.wav"));
  return speech;
}

}  // namespace mien::app

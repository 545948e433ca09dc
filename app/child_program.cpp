#include "app/child_program.h"

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
#include <thread>
#include <utility>

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

/// As programs are given their arguments and their environment, with a null behind; valid while `texts` is as
/// it is.
std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

}  // namespace

struct Child::State {
  explicit State(PrivateFolder made) : folder(std::move(made)) {}
  // Files, not pipes: what it says is read when it has ended, however much it is.
  [[nodiscard]] fs::path out() const { return folder.path() / "out"; }
  [[nodiscard]] fs::path complaints() const { return folder.path() / "complaints"; }

  PrivateFolder folder;
  std::string name;
  Descriptor input, output;
  pid_t id = -1;  ///< Until it was waited for.
};

Child::Child(std::unique_ptr<State> state) : state_(std::move(state)) {}
Child::Child(Child&&) noexcept = default;

Child::~Child() {
  if (state_ == nullptr || state_->id <= 0) return;
  ask_to_stop();
  state_->output.close();
  while (::waitpid(state_->id, nullptr, 0) < 0 && errno == EINTR) {
  }
}

Result<Child> Child::start(std::vector<std::string> command, Input input,
                           std::vector<std::string> environment, Output output) {
  MIEN_TRY_ASSIGN(PrivateFolder folder, PrivateFolder::make());
  auto state = std::make_unique<State>(std::move(folder));
  state->name = command.front();
  const fs::path out = state->out(), complaints = state->complaints();
  Descriptor theirs, their_output;
  if (output == Output::read) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::io, std::strerror(errno), state->name);
    state->output = Descriptor(ends[0]);
    their_output = Descriptor(ends[1]);
  }
  if (input == Input::fed) {
    // A socket rather than a pipe: writing to a child that is gone then gives an error instead of a signal.
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      return fail(ErrorCode::io, std::strerror(errno), state->name);
    state->input = Descriptor(ends[0]);
    theirs = Descriptor(ends[1]);
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input == Input::fed)
    posix_spawn_file_actions_adddup2(&actions, theirs.get(), STDIN_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  constexpr int kNew = O_WRONLY | O_CREAT | O_TRUNC;
  if (output == Output::read)
    posix_spawn_file_actions_adddup2(&actions, their_output.get(), STDOUT_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kNew, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, complaints.c_str(), kNew, 0600);
  const std::vector<char*> argv = pointers(command), envp = pointers(environment);
  const int code = ::posix_spawnp(&state->id, argv.front(), &actions, nullptr, argv.data(),
                                  environment.empty() ? environ : envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (code == 0) return Child(std::move(state));
  state->id = -1;
  if (code == ENOENT) return fail(ErrorCode::not_found, "there is no program `" + state->name + "`");
  return fail(ErrorCode::io, std::strerror(code), state->name);
}

Result<void> Child::send(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(state_->input.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return fail(ErrorCode::io, "it listens no more", state_->name);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

Result<std::size_t> Child::receive(std::span<std::uint8_t> bytes) {
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t n = ::read(state_->output.get(), bytes.data() + have, bytes.size() - have);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::io, std::strerror(errno), state_->name);
    if (n == 0) break;
    have += static_cast<std::size_t>(n);
  }
  return have;
}

Result<ChildOutput> Child::wait() {
  if (state_->id <= 0) return fail(ErrorCode::io, "it has ended already", state_->name);
  state_->input.close();
  const bool was_read = state_->output.get() >= 0;
  state_->output.close();
  int status = 0;
  while (::waitpid(state_->id, &status, 0) < 0 && errno == EINTR) {
  }
  state_->id = -1;
  ChildOutput output;
  output.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (!was_read) {
    MIEN_TRY_ASSIGN(output.out, read_text(state_->out()));
  }
  MIEN_TRY_ASSIGN(output.complaints, read_text(state_->complaints()));
  return output;
}

bool Child::has_ended() const {
  siginfo_t ended{};
  // Looked at only: wait() takes its status.
  return state_->id <= 0 ||
         ::waitid(P_PID, static_cast<id_t>(state_->id), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 ||
         ended.si_pid != 0;
}

void Child::ask_to_stop() {
  if (state_->id <= 0) return;
  ::kill(state_->id, SIGTERM);
  state_->input.close();  // Whatever it waits for: it ends, and takes away what it began.
}

Result<ChildOutput> Child::stop(std::chrono::milliseconds patience) {
  if (state_->id <= 0) return fail(ErrorCode::io, "it has ended already", state_->name);
  ask_to_stop();
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!has_ended()) {
    if (std::chrono::steady_clock::now() >= until) {
      ::kill(state_->id, SIGKILL);
      MIEN_TRY(wait());
      return fail(ErrorCode::io, "it did not end when it was asked to, and was killed", state_->name);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return wait();
}

Result<ChildOutput> run_child(std::vector<std::string> command, std::vector<std::string> environment) {
  MIEN_TRY_ASSIGN(Child child, Child::start(std::move(command), Child::Input::none, std::move(environment)));
  return child.wait();
}

Result<void> become_program(const fs::path& program, std::vector<std::string> command,
                            std::vector<std::string> environment) {
  ::execve(program.c_str(), pointers(command).data(),
           environment.empty() ? environ : pointers(environment).data());
  return fail(ErrorCode::io, std::strerror(errno), program.string());
}

namespace {

/// Of a helper that is missing.
std::string how_to_build(const std::string& helper) {
  const auto built_with = [](std::string_view option, std::string_view needs) {
    return fmt::format("build Mien with {} on, as script/bootstrap and cmake --preset release do{}", option,
                       needs);
  };
  if (helper == "mien-media")
    return built_with("MIEN_MEDIA",
                      "; it needs Debian's libavformat-dev, libavcodec-dev, libswscale-dev, "
                      "libswresample-dev and libespeak-ng-dev");
  if (helper == "mien-train") return built_with("MIEN_TRAIN", "; it needs Debian's libtorch-dev");
  return built_with("MIEN_LAB", "");
}

}  // namespace

Result<fs::path> find_helper(const std::string& name) {
  MIEN_TRY_ASSIGN(const fs::path self, running_program());
  std::error_code code;
  const fs::path path = self.parent_path() / name;
  if (!fs::exists(path, code))
    return fail(ErrorCode::not_found,
                fmt::format("the helper {} is not beside {}", name, self.filename().string()),
                self.parent_path().string(), how_to_build(name));
  return path;
}

}  // namespace mien::app

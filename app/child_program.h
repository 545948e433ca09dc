#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"

namespace mien::app {

/// What another program said until it ended.
struct ChildOutput {
  int status = -1;         ///< Its exit status; 128 and the signal's number where one ended it.
  std::string out;         ///< Standard output, ...
  std::string complaints;  ///< ... and standard error.

  [[nodiscard]] bool succeeded() const { return status == 0; }
};

/// Another program at work. Not thread-safe.
class Child {
 public:
  enum class Input { none, fed };
  enum class Output {
    kept,  ///< wait() gives what it said.
    read,  ///< By receive(), while it works.
  };

  /// Starts a program, found along PATH where its name has no slash. `command`: name and arguments;
  /// `environment`: its whole environment, or empty for this program's own. Errors: not_found (no such
  /// program), io.
  [[nodiscard]] static Result<Child> start(std::vector<std::string> command, Input input,
                                           std::vector<std::string> environment = {},
                                           Output output = Output::kept);
  Child(Child&&) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();  ///< Without wait() asks it to stop (SIGTERM, and its input's end), and waits until it has.

  /// Feeds its standard input. Errors: io (it listens no more: wait() says why).
  [[nodiscard]] Result<void> send(std::span<const std::uint8_t> bytes);
  /// Fills `bytes` from its standard output; less only at the output's end. Returns how many there were.
  /// Errors: io.
  [[nodiscard]] Result<std::size_t> receive(std::span<std::uint8_t> bytes);
  /// Ends its input, reads no more of it, and waits for its end. Errors: io (it has been waited for already).
  [[nodiscard]] Result<ChildOutput> wait();
  /// Whether it has ended, so that wait() gives at once what it said.
  [[nodiscard]] bool has_ended() const;
  /// Asks it to stop (SIGTERM, and its input's end), and does not wait for that. Nothing where it has been
  /// waited for.
  void ask_to_stop();
  /// ask_to_stop(), and waits until it has. One that goes on beyond `patience` is killed. Errors: io (it was
  /// killed, or has been waited for already).
  [[nodiscard]] Result<ChildOutput> stop(std::chrono::milliseconds patience);

 private:
  struct State;
  explicit Child(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Runs a program without standard input to its end. Errors: Child::start()'s.
[[nodiscard]] Result<ChildOutput> run_child(std::vector<std::string> command,
                                            std::vector<std::string> environment = {});

/// This process becomes that program, so that its exit status, its terminal and Ctrl-C are this one's; comes
/// back only with an error. `command` begins with the name that the program is told to be called by;
/// `environment`: as Child::start() has it. Errors: io.
[[nodiscard]] Result<void> become_program(const std::filesystem::path& program,
                                          std::vector<std::string> command,
                                          std::vector<std::string> environment = {});

/// Where a helper program ("mien-lab", "mien-media", "mien-train") stands: beside this program's real path.
/// Errors: not_found, with what to build or install.
[[nodiscard]] Result<std::filesystem::path> find_helper(const std::string& name);

}  // namespace mien::app

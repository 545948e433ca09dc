#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/folder.h"

extern char** environ;

namespace mien::app::test {

/// In memory: a kill needs no real disk.
struct Folder : mien::test::Folder {
  Folder() : mien::test::Folder(On::memory) {}
  [[nodiscard]] std::string operator/(const std::string& name) const {
    return mien::test::Folder::operator/(name).string();
  }
};

inline std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// The built program, which stands beside its tests' folder.
inline std::string program_path() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "app/mien").string();
}

/// Starts `mien` with nothing on its standard input; -1 when it cannot be started.
inline pid_t start(std::vector<std::string> arguments, const std::string& out, const std::string& err) {
  arguments.insert(arguments.begin(), program_path());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = -1;
  const int code = ::posix_spawn(&process, program_path().c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(code, 0) << program_path();
  return code == 0 ? process : -1;
}

/// What a run of the program came to.
struct Outcome {
  int status = -1;  ///< Exit status; 128 and the signal's number where one ended it.
  std::string out;
  std::string err;
};

inline Outcome run(const std::vector<std::string>& arguments) {
  const Folder folder;
  const pid_t process = start(arguments, folder / "out", folder / "err");
  int status = 0;
  if (process > 0) ::waitpid(process, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), content(folder / "out"),
          content(folder / "err")};
}

inline std::string joined(const std::vector<std::string>& words) {
  std::string line = "mien";
  for (const std::string& word : words) line += " " + word;
  return line;
}

}  // namespace mien::app::test

#include "app/child_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/private_folder.h"
#include "mien/core/files.h"

extern char** environ;

namespace mien::app {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

Result<ChildOutput> run_child(std::vector<std::string> command, std::vector<std::string> environment) {
  // Files, not pipes: nobody has to read both at once.
  MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
  const std::filesystem::path out = folder.path() / "out", complaints = folder.path() / "complaints";
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, complaints.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::vector<char*> argv = pointers(command), envp = pointers(environment);
  pid_t process = -1;
  const int code = ::posix_spawnp(&process, argv.front(), &actions, nullptr, argv.data(),
                                  environment.empty() ? environ : envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (code == ENOENT) return fail(ErrorCode::not_found, "there is no program `" + command.front() + "`");
  if (code != 0) return fail(ErrorCode::io, std::strerror(code), command.front());
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  ChildOutput output;
  output.succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  MIEN_TRY_ASSIGN(output.out, read_text(out));
  MIEN_TRY_ASSIGN(output.complaints, read_text(complaints));
  return output;
}

}  // namespace mien::app

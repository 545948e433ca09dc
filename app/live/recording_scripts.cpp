#include "app/live/recording_scripts.h"

#include <algorithm>
#include <system_error>

#include "mien/core/files.h"

namespace mien::app {
namespace {

bool belongs_to_blocks(const session::PromptScript& script) {
  return std::ranges::none_of(script.prompts,
                              [](const session::Prompt& prompt) { return prompt.block.empty(); });
}

}  // namespace

Result<std::vector<live::RecordingScript>> recording_scripts(const std::vector<std::string>& own) {
  std::vector<live::RecordingScript> scripts;
  const auto add = [&scripts](const std::filesystem::path& file, session::PromptScript script) {
    const std::string name = file.stem().string();
    if (std::ranges::find(scripts, name, &live::RecordingScript::name) == scripts.end())
      scripts.push_back({name, std::move(script)});
  };
  for (const std::string& file : own) {
    MIEN_TRY_ASSIGN(session::PromptScript script, session::read_prompts(file));
    if (!belongs_to_blocks(script))
      return fail(
          ErrorCode::malformed, "a prompt of it belongs to no block", "--texts " + file,
          "give each one a block, as prompts/dataset_en.toml does; mien record --prompts asks for poses");
    add(file, std::move(script));
  }
  MIEN_TRY_ASSIGN(const std::filesystem::path folder, find_resource("prompts"));
  std::vector<std::filesystem::path> shipped;
  std::error_code code;
  using Folder = std::filesystem::directory_iterator;
  for (Folder file(folder, code); !code && file != Folder(); file.increment(code))
    if (file->path().extension() == ".toml") shipped.push_back(file->path());
  std::ranges::sort(shipped);
  for (const std::filesystem::path& file : shipped) {
    MIEN_TRY_ASSIGN(session::PromptScript script, session::read_prompts(file));
    if (belongs_to_blocks(script)) add(file, std::move(script));
  }
  return scripts;
}

}  // namespace mien::app

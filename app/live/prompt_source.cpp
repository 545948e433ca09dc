#include "app/live/prompt_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "mien/builtin_face/markers.h"
#include "mien/core/files.h"
#include "mien/core/random.h"
#include "mien/virtual/eyewear/marker_poses.h"

namespace mien::app {
namespace {

constexpr std::string_view kDrawn = "components:";
/// As the study measures before its experiment.
constexpr double kMeasured_s = 300;

/// Takes a whole number from the front of `text`; false when there is none.
template <class T>
bool take_number(std::string_view& text, T& out) {
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (wrong != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

Result<session::PromptScript> draw_prompts(const std::string& what) {
  std::string_view rest(what);
  rest.remove_prefix(kDrawn.size());
  std::size_t count = 0;
  std::uint64_t seed = 1;
  bool good = take_number(rest, count);
  if (good && rest.starts_with(':')) {
    rest.remove_prefix(1);
    good = take_number(rest, seed);
  }
  if (!good || !rest.empty() || count < 1 || count > session::kMaxPrompts)
    return fail(ErrorCode::bad_usage, "not a number of poses to draw", "--prompts " + what,
                fmt::format("write components:N or components:N:SEED, N from 1 to {}", session::kMaxPrompts));
  MIEN_TRY_ASSIGN(const std::filesystem::path file, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet markers, builtin_face::read_markers(file));
  const Random root = Random(seed).fork("prompts");
  MIEN_TRY_ASSIGN(const virt::MarkerPoses poses,
                  virt::MarkerPoses::measure(markers, kMeasured_s, root.fork("before")));
  Random drawn = root.fork("targets");
  session::PromptScript script{what, {}};
  for (std::size_t i = 0; i < count; ++i) {
    session::Prompt& prompt = script.prompts.emplace_back();
    prompt.name = fmt::format("pose {}", i + 1);
    prompt.target = poses.draw(drawn);
    // Nobody can see a thousandth, and takes stay small.
    for (float& weight : prompt.target.values) weight = std::round(weight * 1000) / 1000;
  }
  return script;
}

bool belongs_to_blocks(const session::PromptScript& script) {
  return std::ranges::none_of(script.prompts,
                              [](const session::Prompt& prompt) { return prompt.block.empty(); });
}

}  // namespace

Result<session::PromptScript> load_prompts(const std::string& what) {
  if (what.starts_with(kDrawn)) return draw_prompts(what);
  std::error_code ignored;
  const bool is_name = what.find('/') == std::string::npos && !what.ends_with(".toml");
  if (!is_name || std::filesystem::exists(what, ignored)) return session::read_prompts(what);
  const auto shipped = find_resource("prompts/" + what + ".toml");
  if (!shipped)
    return fail(ErrorCode::not_found, "there are no such prompts", what,
                "give a file, one_minute, or components:600");
  return session::read_prompts(*shipped);
}

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

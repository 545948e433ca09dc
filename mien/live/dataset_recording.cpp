#include "mien/live/dataset_recording.h"

#include <utility>

#include "mien/live/asked_prompts.h"
#include "mien/session/json_fields.h"

namespace mien::live {

using nlohmann::json;
using session::flag_field;
using session::text_field;

Result<DatasetWish> dataset_wish(const json& begin) {
  if (!begin.is_object())
    return fail(ErrorCode::malformed, "\"begin\" is no object", "dataset",
                "docs/reference/page_protocol.md lists its fields");
  if (!flag_field(begin, "agreed"))
    return fail(ErrorCode::bad_usage, "the performer has not agreed to be recorded", "dataset",
                "nothing is recorded for a dataset before that");
  DatasetWish wish{.dataset = text_field(begin, "name"),
                   .script = text_field(begin, "script"),
                   .consent = {.performer = text_field(begin, "performer"),
                               .recorded_by = text_field(begin, "recorded_by"),
                               .purpose = text_field(begin, "purpose"),
                               .sound = flag_field(begin, "sound"),
                               .video = flag_field(begin, "video")},
                   .by_voice = text_field(begin, "pace") == "voice"};
  return wish;
}

json dataset_contents_json(const DatasetShelf::Contents& contents) {
  json datasets = json::array();
  for (const DatasetShelf::Dataset& dataset : contents.datasets) {
    json performers = json::array();
    for (const auto& [name, performer] : dataset.performers)
      performers.push_back({{"name", name}, {"takes", performer.takes}, {"lines", performer.lines}});
    datasets.push_back({{"name", dataset.name}, {"performers", std::move(performers)}});
  }
  json scripts = json::array();
  for (const RecordingScript& script : contents.scripts) {
    json blocks = json::array();
    for (const session::Prompt& prompt : script.script.prompts) {
      if (blocks.empty() || blocks.back()["name"] != prompt.block)
        blocks.push_back({{"name", prompt.block}, {"lines", 0}, {"seconds", 0.0}});
      blocks.back()["lines"] = blocks.back()["lines"].get<int>() + 1;
      blocks.back()["seconds"] = blocks.back()["seconds"].get<double>() + prompt.seconds;
    }
    scripts.push_back({{"name", script.name},
                       {"title", script.script.name},
                       {"language", script.script.language},
                       {"blocks", std::move(blocks)}});
  }
  return {{"datasets", std::move(datasets)}, {"scripts", std::move(scripts)}};
}

std::vector<session::Command> DatasetRecording::begin(const DatasetPlan& plan, std::string_view prompts,
                                                      bool hears) {
  state_ = State{.name = plan.wish.dataset,
                 .performer = plan.wish.consent.performer,
                 .take = plan.take.filename().string(),
                 .lines = plan.prompts.size(),
                 .done = plan.done};
  ending_ = asked_ = false;
  using Do = session::Prompting::Do;
  std::vector<session::Command> commands;
  if (asks_in(prompts)) commands.emplace_back(session::Prompting{Do::stop});
  deafened_ = hears && !plan.wish.consent.sound;
  if (deafened_) commands.emplace_back(session::Shape{R"({"merge": {"audio": false}})"});
  commands.emplace_back(session::GiveConsent{plan.wish.consent});
  commands.emplace_back(session::Prompting{plan.wish.by_voice ? Do::voice : Do::key});
  for (const session::Prompt& prompt : plan.prompts) commands.emplace_back(session::AddPrompt{prompt});
  return commands;
}

DatasetRecording::Next DatasetRecording::look(const Recorder::State& recording, std::string_view prompts) {
  if (!state_ || state_->over) return {};
  const bool asks = asks_in(prompts);
  asked_ = asked_ || asks;
  Next next;
  if (!recording.on) {
    state_->over = true;
    state_->error = recording.error;
  } else if (ending_ || (asked_ && !asks)) {
    state_->over = true;
    next.end_recording = true;
  }
  if (!state_->over) return next;
  // Where it does not ask yet, it is about to.
  if (asks || !asked_) next.commands.emplace_back(session::Prompting{session::Prompting::Do::stop});
  next.commands.emplace_back(session::EndConsent{});
  if (std::exchange(deafened_, false))
    next.commands.emplace_back(session::Shape{R"({"merge": {"audio": true}})"});
  return next;
}

}  // namespace mien::live

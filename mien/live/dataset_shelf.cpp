#include "mien/live/dataset_shelf.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <new>
#include <optional>
#include <system_error>

#include "mien/core/excerpt.h"
#include "mien/live/page_requests.h"
#include "mien/session/recorded_lines.h"
#include "mien/take/take.h"

namespace mien::live {
namespace {

/// Of a take's name what people's names give to it.
std::string file_name_of(const std::string& performer) {
  std::string name;
  for (const char c : performer) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain || c == '-')
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  return name.empty() ? "performer" : name;
}

std::filesystem::path new_take(const std::filesystem::path& folder, const std::string& performer) {
  const std::string stem =
      fmt::format("{}_{:%Y-%m-%d_%H-%M-%S}", file_name_of(performer), fmt::localtime(std::time(nullptr)));
  return unused(folder / (stem + ".mien"));
}

}  // namespace

DatasetShelf::DatasetShelf(std::filesystem::path folder, Scripts scripts)
    : folder_(std::move(folder)),
      scripts_(std::move(scripts)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

DatasetShelf::~DatasetShelf() = default;

void DatasetShelf::list(std::filesystem::path growing, std::function<void(Result<Contents>)> answer) {
  post([this, growing = std::move(growing), answer = std::move(answer)] { answer(contents(growing)); });
}

void DatasetShelf::plan(DatasetWish wish, std::filesystem::path growing,
                        std::function<void(Result<DatasetPlan>)> answer) {
  post([this, wish = std::move(wish), growing = std::move(growing), answer = std::move(answer)]() mutable {
    answer(planned(std::move(wish), growing));
  });
}

void DatasetShelf::post(std::function<void()> job) {
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void DatasetShelf::run(const std::stop_token& stop) {
  stop_ = stop;
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !jobs_.empty(); })) {
    if (stop.stop_requested()) return;
    const std::function<void()> job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    try {
      job();
    } catch (const std::bad_alloc&) {
      known_.clear();  // Memory is short: whoever asked hears nothing, and the session goes on.
    }
    lock.lock();
  }
}

const DatasetShelf::Recorded* DatasetShelf::recorded_in(const std::filesystem::path& take) {
  if (stop_.stop_requested()) return nullptr;
  const auto version = FileVersion::of(take);
  if (!version) return nullptr;
  Recorded& known = known_[take];
  if (known.of == *version) return &known;
  known = {.of = *version};
  const auto opened = take::Take::open(take);
  if (!opened) return &known;
  const auto events = opened->events();
  if (!events) return &known;
  const std::optional<session::RecordedPart> part = session::recorded_part(*events);
  if (!part) return &known;
  known.performer = part->consent.performer;
  for (const session::RecordedLine* line : session::lines_that_count(*part))
    if (line->poor.empty()) known.lines.emplace(line->name, line->text);
  return &known;
}

std::vector<std::filesystem::path> DatasetShelf::takes_of(const std::filesystem::path& folder,
                                                          const std::filesystem::path& growing) {
  std::vector<std::filesystem::path> takes;
  std::error_code code;
  using Folder = std::filesystem::directory_iterator;
  for (Folder file(folder, code); !code && file != Folder(); file.increment(code))
    if (file->path().extension() == ".mien" && file->path() != growing) takes.push_back(file->path());
  std::ranges::sort(takes);
  takes.resize(std::min(takes.size(), kMaxTakes));
  return takes;
}

Result<DatasetShelf::Contents> DatasetShelf::contents(const std::filesystem::path& growing) {
  Contents out;
  MIEN_TRY_ASSIGN(out.scripts, scripts_());
  std::vector<std::filesystem::path> folders;
  std::error_code code;
  using Folder = std::filesystem::directory_iterator;
  for (Folder file(folder_, code); !code && file != Folder(); file.increment(code)) {
    std::error_code ignored;
    if (file->is_directory(ignored) && check_file_name(file->path().filename().string(), "dataset"))
      folders.push_back(file->path());
  }
  std::ranges::sort(folders);
  for (const std::filesystem::path& folder : folders) {
    if (out.datasets.size() == kMaxDatasets) break;
    Dataset dataset{folder.filename().string(), {}};
    std::map<std::string, std::set<LineKey>> lines;
    for (const std::filesystem::path& take : takes_of(folder, growing)) {
      const Recorded* const recorded = recorded_in(take);
      if (recorded == nullptr || recorded->performer.empty()) continue;
      ++dataset.performers[recorded->performer].takes;
      lines[recorded->performer].insert(recorded->lines.begin(), recorded->lines.end());
    }
    for (auto& [name, performer] : dataset.performers) performer.lines = lines[name].size();
    // Folders of anything else stand there, too.
    if (!dataset.performers.empty()) out.datasets.push_back(std::move(dataset));
  }
  return out;
}

Result<DatasetPlan> DatasetShelf::planned(DatasetWish wish, const std::filesystem::path& growing) {
  MIEN_TRY(check_file_name(wish.dataset, "dataset"));
  MIEN_TRY(session::check_consent(wish.consent, "dataset"));
  MIEN_TRY_ASSIGN(std::vector<RecordingScript> scripts, scripts_());
  const auto script = std::ranges::find(scripts, wish.script, &RecordingScript::name);
  if (script == scripts.end())
    return fail(ErrorCode::not_found,
                fmt::format("there is no recording script \"{}\"", excerpt(wish.script)), "dataset",
                "choose one of the list, or start the session with --texts FILE.toml");
  const std::filesystem::path folder = folder_ / wish.dataset;
  std::set<LineKey> recorded;
  for (const std::filesystem::path& take : takes_of(folder, growing))
    if (const Recorded* const one = recorded_in(take);
        one != nullptr && one->performer == wish.consent.performer)
      recorded.insert(one->lines.begin(), one->lines.end());
  DatasetPlan plan;
  for (session::Prompt& prompt : script->script.prompts) {
    if (recorded.contains({prompt.name, prompt.text}))
      ++plan.done;
    else
      plan.prompts.push_back(std::move(prompt));
  }
  if (plan.prompts.empty())
    return fail(ErrorCode::bad_usage,
                fmt::format("{} has recorded all {} lines of it", excerpt(wish.consent.performer), plan.done),
                "dataset", "choose another script, or another dataset");
  plan.take = new_take(folder, wish.consent.performer);
  plan.wish = std::move(wish);
  return plan;
}

}  // namespace mien::live

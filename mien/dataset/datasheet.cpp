#include "mien/dataset/datasheet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "mien/core/excerpt.h"

namespace mien::dataset {
namespace {

/// A stranger's text, as Markdown shows it: on one line, and nothing in it a sign.
std::string markdown_text(std::string_view text, std::size_t letters) {
  constexpr std::string_view kSigns = "\\`*_{}[]<>()#+!|&~$";
  std::string out;
  for (const char c : excerpt(text, letters)) {
    if (kSigns.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

double minutes(double seconds) {
  return seconds / 60;
}

class Datasheet {
 public:
  Datasheet(const ExportRequest& request, const Export& exported)
      : request_(request), exported_(exported), totals_(exported.dataset.totals()) {}

  std::string text() {
    what_it_is();
    who();
    how_recorded();
    files();
    labels();
    shapes();
    left_out();
    limits();
    return std::move(out_);
  }

 private:
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  /// "train", or "none".
  std::string set_of(const std::string& person) const {
    const std::optional<Split> split = exported_.splits.where(person);
    return split ? std::string(kSplitNames[static_cast<std::size_t>(*split)]) : "none";
  }

  void what_it_is();
  void who();
  void how_recorded();
  void videos();
  void files();
  void labels();
  void shapes();
  void left_out();
  void limits();

  const ExportRequest& request_;
  const Export& exported_;
  const TakeTotals totals_;
  std::string out_;
};

void Datasheet::what_it_is() {
  const RecordedDataset& dataset = exported_.dataset;
  std::filesystem::path folder = dataset.folder.lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  add("# Datasheet: {}\n\n", markdown_text(folder.filename().string(), 100));
  add("How skin turns under {} inertial sensors on people's faces while they read and act, and what the face "
      "did: pairs to train a network on that tells blendshape weights from such sensors.\n\n",
      dataset.sensors.size());
  add("{} people, {} takes, {:.1f} minutes that count. Windows of {} frames at 60 Hz, one every {} "
      "frames.\n\n",
      dataset.people.size(), dataset.takes.size(), minutes(totals_.seconds.counted), request_.window,
      request_.stride);
  add("Written by {}:\n\n    {}\n\n", markdown_text(request_.software, 100), excerpt(request_.command, 1000));
  add("The same takes, splits and command give the same bytes.\n\n");
  add("| set | people | windows | minutes | files |\n|---|---|---|---|---|\n");
  for (std::size_t i = 0; i < kSplitNames.size(); ++i) {
    const ExportedSplit& set = exported_.sets[i];
    std::size_t people = 0;
    for (const RecordedPerson& person : dataset.people)
      if (exported_.splits.where(person.name) == static_cast<Split>(i)) ++people;
    add("| {} | {} | {} | {:.1f} | {} |\n", kSplitNames[i], people, set.windows, minutes(set.seconds),
        set.files.empty() ? "none" : fmt::format("{}", fmt::join(set.files, ", ")));
  }
  add("\nNobody is in two sets. Minutes are those within windows; a frame in several windows counts "
      "once.\n\n");
}

void Datasheet::who() {
  add("## Who, and what they agreed to\n\n");
  add("Names are as people gave them with their consent: names or codes. Numbers of a face's motion are "
      "personal data; what they may be used for is what their owner agreed to.\n\n");
  add("| person | set | takes | minutes | recorded and kept by | for | sound recorded | video recorded |\n"
      "|---|---|---|---|---|---|---|---|\n");
  struct Amount {
    std::size_t takes = 0;
    double seconds = 0;
  };
  for (const RecordedPerson& person : exported_.dataset.people) {
    // What they agreed to may be different from one take to the next.
    std::map<std::tuple<bool, std::string, std::string, bool, bool>, Amount> agreed;
    for (const std::size_t place : person.takes) {
      const TakeOverview& take = exported_.dataset.takes[place];
      const session::Consent consent = take.consent.value_or(session::Consent());
      Amount& amount = agreed[{take.consent.has_value(), consent.recorded_by, consent.purpose, consent.sound,
                               consent.video}];
      ++amount.takes;
      amount.seconds += take.seconds.counted;
    }
    for (const auto& [terms, amount] : agreed) {
      const auto& [consented, by, purpose, sound, video] = terms;
      add("| {} | {} | {} | {:.1f} | {} | {} | {} | {} |\n", markdown_text(person.name, 60),
          set_of(person.name), amount.takes, minutes(amount.seconds),
          consented ? markdown_text(by, 200) : "nobody: a virtual performer",
          consented ? markdown_text(purpose, 1000) : "any", sound ? "yes" : "no", video ? "yes" : "no");
    }
  }
  add("\n");
}

void Datasheet::how_recorded() {
  add("## How it was recorded\n\n");
  add("Sensors on the skin and one behind the ear, each with gyroscope and accelerometer, were calibrated on "
      "a face at rest and a nodding head. Where a phone was the truth, it filmed the face meanwhile and told "
      "its weights; its time on the sensors' was found by how the face moves (offset in the take's middle "
      "and its standard deviation, drift; agreement is the share of the variance of jaw and smile that the "
      "skin foretells). What it told of the face at rest is taken off.\n\n");
  add("| take | person | recorded | rig | truth | minutes | of | offset ms | +- | drift ppm | agreement |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const TakeOverview& take : exported_.dataset.takes) {
    add("| {}{} | {} | {} | {} | {} | {:.1f} | {:.1f} |", markdown_text(take.path.filename().string(), 100),
        take.finished ? "" : " (cut off)", markdown_text(take.performer, 60),
        markdown_text(take.created_utc, 30), markdown_text(take.rig, 60), take.sync ? "phone" : "its own",
        minutes(take.seconds.counted), minutes(take.seconds.all()));
    if (take.sync) {
      const phone::TimeAlignment& at = take.sync->alignment;
      add(" {:.1f} | {:.1f} | {:+.1f} | {:.2f} |\n", 1e3 * at.offset_s, 1e3 * at.offset_sigma_s, at.drift_ppm,
          at.agreement);
    } else {
      add(" | | | |\n");
    }
  }
  std::set<std::string> software;
  for (const TakeOverview& take : exported_.dataset.takes) software.insert(take.software);
  std::vector<std::string> names;
  for (const std::string& name : software)
    if (names.size() < 10) names.push_back(markdown_text(name, 60));
  add("\nRecorded with {}.\n\n", fmt::join(names, ", "));
  videos();
}

void Datasheet::videos() {
  std::size_t takes = 0, files = 0;
  double megabytes = 0;
  for (const TakeOverview& take : exported_.dataset.takes) {
    takes += take.videos.empty() ? 0 : 1;
    files += take.videos.size();
    megabytes += megabytes_of(take.videos);
  }
  if (files == 0) {
    add("No video of a face was beside these takes.\n\n");
    return;
  }
  add("Beside {} of the takes lies video of the performer's face, in {} files of {:.1f} MB together. None of "
      "it is in this export: a face on video tells who somebody is. Whoever may have it gets it from who "
      "keeps the takes.\n\n",
      takes, files, megabytes);
}

void Datasheet::files() {
  const std::size_t n = exported_.dataset.sensors.size();
  add("## What is in a file\n\n");
  add("Safetensors, fp32. Its metadata hold `sensors`, `shapes`, `takes` and `lines` as JSON lists.\n\n");
  add("| tensor | shape | what |\n|---|---|---|\n");
  add("| `condition` | windows x {} x {} | {} features, then {} flags |\n", request_.window, 9 * n, 7 * n,
      2 * n);
  add("| `weights` | windows x {} x {} | the truth, 0 to 1, a shape each |\n", request_.window,
      face::kShapeCount);
  add("| `line` | windows x {} | place in `lines` of what was read or asked for; -1: nothing |\n",
      request_.window);
  add("| `take` | windows | place in `takes`, which name file and person |\n");
  add("| `begin_s` | windows | the window's first frame, s from the take's |\n\n");
  add("Features, for each sensor in turn: linear acceleration against the head x y z, m/s^2, then the skin's "
      "rotation from the neutral face, a unit quaternion w x y z with w >= 0. Both are in the head's frame: "
      "+X to the performer's left, +Y up, +Z out of the face. They are not normalised. Flags, 0 or 1: "
      "whether the rotation is there, a sensor each, then whether the acceleration is. What is not there is "
      "0, a rotation 1 0 0 0. Left and right are the performer's own.\n\n");
  std::vector<std::string> names;
  for (const std::string& sensor : exported_.dataset.sensors) names.push_back(markdown_text(sensor, 100));
  add("Sensors, in order: {}.\n\n", fmt::join(names, ", "));
}

void Datasheet::labels() {
  add("## Labels\n\n");
  add("{} lines are good, {} are poor and left out. Between lines the performer moved as they liked.\n\n",
      totals_.good_lines, totals_.poor_lines);
  if (totals_.blocks.empty() && totals_.emotions.empty() && totals_.languages.empty()) return;
  add("| label | | lines | minutes |\n|---|---|---|---|\n");
  const auto add_rows = [this](std::string_view kind, const LabelAmounts& amounts) {
    for (const auto& [label, amount] : amounts)
      add("| {} | {} | {} | {:.1f} |\n", kind, markdown_text(label, 60), amount.lines,
          minutes(amount.seconds));
  };
  add_rows("block", totals_.blocks);
  add_rows("emotion", totals_.emotions);
  add_rows("language", totals_.languages);
  add("\n");
}

void Datasheet::shapes() {
  add("## Shapes\n\nIn the order of `weights`, ICT-FaceKit's names; between which weights all but the "
      "extreme hundredths of the frames are.\n\n");
  add("| | shape | 1 % | 99 % |\n|---|---|---|---|\n");
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    add("| {} | {} | {:.2f} | {:.2f} |\n", k, markdown_text(face::kShapeNames[k], 60),
        exported_.dataset.ranges[k].low, exported_.dataset.ranges[k].high);
  add("\n");
}

void Datasheet::left_out() {
  const TakeSeconds& seconds = totals_.seconds;
  add("## What was left out, and why\n\n");
  add("| of the takes that count | minutes |\n|---|---|\n");
  add("| no face was told | {:.1f} |\n", minutes(seconds.without_face));
  add("| before the calibration was over | {:.1f} |\n", minutes(seconds.before_calibration));
  add("| in lines that were poor | {:.1f} |\n", minutes(seconds.poor));
  add("| no sensor was there | {:.1f} |\n", minutes(seconds.unfelt));
  add("| less than two seconds between two of these | {:.1f} |\n", minutes(seconds.brief));
  add("| in no window: shorter than one, or the end of a stretch | {:.1f} |\n\n",
      minutes(exported_.too_short_s));
  add("What was recorded before somebody consented belongs to nobody, and is in no row.\n\n");
  if (exported_.dataset.left_out.empty()) {
    add("No take was left out.\n\n");
    return;
  }
  add("| take left out | why |\n|---|---|\n");
  for (const LeftOutTake& take : exported_.dataset.left_out)
    add("| {} | {} |\n", markdown_text(take.path.filename().string(), 100), markdown_text(take.why, 400));
  add("\n");
}

void Datasheet::limits() {
  add("## Known limits\n\n");
  bool by_phone = false;
  for (const TakeOverview& take : exported_.dataset.takes) by_phone = by_phone || take.sync;
  if (by_phone)
    add("- A phone's truth is what a phone tells: it smooths, and two phones disagree about one face.\n");
  add("- Sound is in the takes, and video beside them, not here; so are texts that were read, packets and "
      "samples.\n"
      "- Lines that were poor may be missing for a reason that has to do with the face: sensors come off, "
      "and faces are lost, where they move most.\n"
      "- Where each wearer's sensors sat differs from one take to the next, and is not known.\n"
      "- A label is what was asked for, not what was felt.\n");
}

}  // namespace

std::string datasheet_of(const ExportRequest& request, const Export& exported) {
  return Datasheet(request, exported).text();
}

}  // namespace mien::dataset

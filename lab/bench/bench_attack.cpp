#include "lab/bench/benchmarks.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "app/json_output.h"
#include "app/live/perform_network.h"
#include "app/seed_option.h"
#include "lab/bench/attack.h"
#include "lab/bench/attacked_session.h"
#include "lab/bench/clock.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

/// A session that nobody attacks is run before each so many that somebody does.
constexpr std::size_t kAttacksEach = 3;

struct AttackOptions {
  SceneRequest scene;
  std::vector<std::string> names;
  std::string keys = "both";
  std::size_t rounds = 1;
  bool brief = false;
  std::string to;
  std::string headset_model;
  bool json = false;
};

std::string all_names() {
  std::vector<std::string_view> names;
  for (const Attack& attack : attacks()) names.push_back(attack.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The attacks that were asked for; none named: all.
Result<std::vector<const Attack*>> chosen(const std::vector<std::string>& names) {
  std::vector<const Attack*> out;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(attacks(), name, &Attack::name);
    if (found == attacks().end())
      return fail(ErrorCode::bad_usage, "no such attack", "--attack " + name, "one of " + all_names());
    out.push_back(&*found);
  }
  if (names.empty())
    for (const Attack& attack : attacks()) out.push_back(&attack);
  return out;
}

/// All runs of one of the table's parts: of sessions with the same boards, or of cameras.
struct Part {
  Boards boards;
  bool cameras = false;
  std::vector<const Attack*> attacks;
  std::vector<AttackFigures> quiet;
  std::vector<std::vector<AttackFigures>> attacked;  // One list an attack.
};

/// What sessions are attacked in; each is set where there is an attack for it.
struct Scenes {
  AttackScene boards;
  CameraScene cameras;
};

/// Sessions that somebody attacks and such that nobody does, in turn.
Result<void> run_part(const Scenes& scenes, std::size_t rounds, const Progress& progress, Part& part) {
  const std::size_t quiet_a_round = (part.attacks.size() + kAttacksEach - 1) / kAttacksEach;
  const std::size_t runs = rounds * (part.attacks.size() + quiet_a_round);
  std::size_t done = 0;
  const auto run = [&](const Attack* attack) {
    const auto its = [&](double share, std::string_view what) {
      return progress((static_cast<double>(done) + share) / static_cast<double>(runs), what);
    };
    auto figures = part.cameras ? run_attacked_cameras(scenes.cameras, attack, its)
                                : run_attacked_session(scenes.boards, attack, part.boards, its);
    ++done;
    return figures;
  };
  part.attacked.resize(part.attacks.size());
  for (std::size_t round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < part.attacks.size(); ++i) {
      if (i % kAttacksEach == 0) {
        MIEN_TRY_ASSIGN(part.quiet.emplace_back(), run(nullptr));
      }
      MIEN_TRY_ASSIGN(part.attacked[i].emplace_back(), run(part.attacks[i]));
    }
  return {};
}

std::string verdict(const Attack& attack, bool keyed, const std::vector<std::string>& wrong) {
  if (!wrong.empty()) return fmt::format("NOT HELD: {}", fmt::join(wrong, ", "));
  return attack.behaves && !keyed ? "only a key or a choice on the page" : "held";
}

/// `heard_without`: by the same session without a stranger.
std::vector<std::string> attack_cells(std::string_view name, const AttackFigures& f, double heard_without,
                                      const std::string& verdict) {
  std::vector<std::string> cells = cells_of(f, attack_columns());
  cells.insert(cells.begin(), std::string(name));
  cells.push_back(fmt::format("{:.1f}", heard_without > 0 ? 100 * f.heard / heard_without : 0.0));
  cells.push_back(verdict);
  return cells;
}

std::string_view title_of(const Part& part) {
  if (part.cameras) return "Cameras";
  if (part.boards.language == virt::NodeLanguage::slimevr) return "SlimeVR boards, without a key";
  return part.boards.keyed ? "With a key" : "Without a key";
}

std::string_view devices_of(const Part& part) {
  if (part.cameras) return "cameras";
  return part.boards.language == virt::NodeLanguage::slimevr ? "slimevr" : "mien";
}

/// Its rows, printed unless JSON is asked for, and how many of them are not held.
std::size_t conclude(const Part& part, bool print, app::Json& json) {
  const AttackFigures quiet = median(part.quiet);
  measure::Table table = table_of(std::string(title_of(part)), {}, attack_columns());
  table.columns.insert(table.columns.begin(), "stranger");
  table.columns.insert(table.columns.end(), {"heard, %", "verdict"});
  table.rows.push_back(attack_cells("nobody", quiet, quiet.heard, ""));
  std::size_t not_held = 0;
  app::Json rows = app::Json::array();
  for (std::size_t i = 0; i < part.attacks.size(); ++i) {
    const Attack& attack = *part.attacks[i];
    const auto wrong = breaches(attack, part.boards.keyed, part.attacked[i], part.quiet);
    const std::string said = verdict(attack, part.boards.keyed, wrong);
    not_held += wrong.empty() ? 0 : 1;
    const AttackFigures figures = median(part.attacked[i]);
    table.rows.push_back(attack_cells(attack.name, figures, quiet.heard, said));
    rows.push_back({{"attack", attack.name},
                    {"does", attack.does},
                    {"median", json_of(figures, attack_columns())},
                    {"runs", json_of(part.attacked[i], attack_columns())},
                    {"breaches", wrong},
                    {"verdict", said}});
  }
  json.push_back(
      {{"key", part.boards.keyed},
       {"boards", devices_of(part)},
       {"nobody",
        {{"median", json_of(quiet, attack_columns())}, {"runs", json_of(part.quiet, attack_columns())}}},
       {"attacks", std::move(rows)}});
  if (print) fmt::print("{}\n", measure::plain_text(table));
  return not_held;
}

/// All strangers that speak second at once, against a session that somebody else runs on this machine.
Result<void> attack_there(const AttackOptions& options) {
  const auto there = app::parse_target(options.to);
  if (!there || there->language != virt::NodeLanguage::mien || there->host != "127.0.0.1")
    return fail(ErrorCode::bad_usage, "only a session on this machine is attacked", "--to " + options.to,
                "write it as udp://127.0.0.1:5005");
  MIEN_TRY_ASSIGN(const std::filesystem::path path, app::path_or(options.scene.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(path));
  MIEN_TRY_ASSIGN(const std::vector<const Attack*> all, chosen(options.names));
  const Overheard overheard(rig);
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (const Attack* attack : all)
    if (attack->camera == nullptr && attack->begins == Attack::Begins::second &&
        attack->devices == virt::NodeLanguage::mien)
      strangers.push_back(std::make_unique<Stranger>(*attack, there->port, Victims{rig, overheard},
                                                     options.scene.rate, options.scene.seed));
  const Progress progress = app::terminal_progress("bench attack");
  const auto sent = [&] {
    std::uint64_t all_sent = 0;
    for (const auto& stranger : strangers) all_sent += stranger->sent();
    return all_sent;
  };
  for (const auto begun = Clock::now(); seconds_since(begun) < options.scene.seconds;) {
    // Who stops it wants no more of it, which is no error: what was sent stands.
    if (!progress(seconds_since(begun) / options.scene.seconds, fmt::format("{} datagrams", sent()))) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  app::clear_progress();
  const app::Json json = {{"strangers", strangers.size()}, {"sent", sent()}};
  if (options.json)
    app::print_json(json);
  else
    fmt::print("{} strangers sent {} datagrams\n", strangers.size(), sent());
  return {};
}

Result<void> run_attack_bench(AttackOptions options) {
  if (!options.to.empty()) return attack_there(options);
  options.scene.calibrated = !options.brief;
  MIEN_TRY_ASSIGN(const std::vector<const Attack*> all, chosen(options.names));
  const auto of_camera = [](const Attack* attack) { return attack->camera != nullptr; };
  Scenes scenes;
  if (!std::ranges::all_of(all, of_camera)) {
    MIEN_TRY_ASSIGN(scenes.boards, set_attack_scene(options.scene));
  }
  std::vector<Part> parts;
  // SlimeVR's boards cannot be paired.
  for (const Boards boards :
       {Boards{}, Boards{.language = virt::NodeLanguage::slimevr}, Boards{.keyed = true}}) {
    if (options.keys == (boards.keyed ? "without" : "with")) continue;
    Part part{.boards = boards, .attacks = {}, .quiet = {}, .attacked = {}};
    std::ranges::copy_if(all, std::back_inserter(part.attacks), [&](const Attack* attack) {
      return !of_camera(attack) && attack->devices == boards.language;
    });
    if (!part.attacks.empty()) parts.push_back(std::move(part));
  }
  // No key seals pictures.
  if (options.keys != "with" && std::ranges::any_of(all, of_camera)) {
    MIEN_TRY_ASSIGN(scenes.cameras,
                    set_camera_scene(options.scene.seconds, options.headset_model, options.scene.seed));
    Part part{.boards = {}, .cameras = true, .attacks = {}, .quiet = {}, .attacked = {}};
    std::ranges::copy_if(all, std::back_inserter(part.attacks), of_camera);
    parts.push_back(std::move(part));
  }
  const Progress progress = app::terminal_progress("bench attack");
  std::size_t not_held = 0;
  app::Json json = app::Json::array();
  for (std::size_t h = 0; h < parts.size(); ++h) {
    const auto its = [&](double share, std::string_view what) {
      return progress(std::min(0.999, (static_cast<double>(h) + share) / static_cast<double>(parts.size())),
                      what);
    };
    MIEN_TRY(run_part(scenes, options.rounds, its, parts[h]));
    app::clear_progress();
    not_held += conclude(parts[h], !options.json, json);
  }
  progress(1, "attacked");
  if (options.json)
    app::print_json({{"seconds", options.scene.seconds},
                     {"rate", options.scene.rate},
                     {"rounds", options.rounds},
                     {"seed", options.scene.seed},
                     {"not_held", not_held},
                     {"sessions", std::move(json)}});
  if (not_held > 0)
    return fail(ErrorCode::internal, fmt::format("{} attacks are not held", not_held), "bench attack",
                "docs/reference/threat_model.md says what each must not do");
  return {};
}

}  // namespace

void add_attack_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<AttackOptions>();
  const app::Command command = commands.add_under(
      bench, "attack",
      "What a stranger on the network can do to `mien live`: sessions "
      "as processes of their own with a virtual "
      "performer's boards on real sockets, each beside a stranger who "
      "sends junk, fills tables, forges readings "
      "and clocks, before the boards speak or after; and sessions "
      "that ask three cameras, of which one is hostile; beside them "
      "the same sessions without him, in turn. Only "
      "on this machine's loopback",
      "mien bench attack --seconds 20 --rounds 3 --json", [options] { return run_attack_bench(*options); });
  command.add_option("--attack", options->names,
                     fmt::format("Only this one; may be given often: {}", all_names()));
  command
      .add_option("--key", options->keys, "Sessions and boards that are paired, such that are not, or both")
      .one_of({"both", "with", "without"})
      .show_default();
  command.add_option("--seconds", options->scene.seconds, "How long the performer performs in each session")
      .number_between(1.0, 36'000.0)
      .show_default();
  command
      .add_option(
          "--still", options->scene.still_s,
          "How long the performer sits still first: who speaks first and is no sensor is put aside within "
          "five seconds")
      .number_between(0.0, 60.0)
      .show_default();
  command.add_option("--rounds", options->rounds, "How often each is run; the table has medians")
      .in_range(std::size_t{1}, std::size_t{100})
      .show_default();
  command.add_option("--rate", options->scene.rate, "Share of each attack's own rate")
      .number_between(0.001, 10.0)
      .show_default();
  command.add_flag("--brief", options->brief,
                   "Without a calibration, so that neither faces nor times are judged: who is heard, frames, "
                   "memory, bits");
  command.add_option("--to", options->to,
                     "Instead of sessions of its own, attack one that runs at this address of this machine "
                     "(udp://127.0.0.1:PORT) with all that begin after the boards, at once, for --seconds");
  command.add_option("--model", options->scene.model, "The live model (default: the one in models/)");
  command.add_option("--headset-model", options->headset_model,
                     "That of the sessions with cameras (default: the one in models/)");
  app::add_seed_option(command, options->scene.seed, "Who performs, and what strangers draw");
  app::add_json_flag(command, options->json);
}

}  // namespace mien::lab

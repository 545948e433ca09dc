#include "lab/bench/benchmarks.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "app/child_program.h"
#include "app/live/perform_network.h"
#include "lab/bench/clock.h"
#include "lab/bench/hostile_camera.h"
#include "lab/bench/loopback.h"
#include "lab/commands/output.h"
#include "mien/core/files.h"

namespace mien::lab {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::ip::udp;

/// A headset's, and how many unlike pictures they show, again and again.
constexpr std::size_t kCameras = 4, kPictures = 8;

struct StartBench {
  int times = 10;
  Output to;
};

/// A virtual performer who performs all the while, to one port, whoever listens there.
class Performer {
 public:
  /// Begins, and returns when the first packet has come. Errors: the performance's; not_found (the rig).
  static Result<std::unique_ptr<Performer>> begin() {
    MIEN_TRY_ASSIGN(const fs::path rig, find_resource("rigs/default.toml"));
    asio::io_context io;
    udp::socket received = loopback(io);
    auto performer = std::unique_ptr<Performer>(new Performer(rig, received.local_endpoint().port()));
    std::array<std::byte, 2048> packet{};
    received.non_blocking(true);
    boost::system::error_code code;
    while (!performer->over_ && received.receive(asio::buffer(packet), 0, code) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (performer->over_) return std::unexpected(performer->performed_.error());
    return performer;
  }

  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  Performer(const fs::path& rig, std::uint16_t port) : address_(fmt::format("udp://127.0.0.1:{}", port)) {
    performing_ = std::jthread([this, rig](const std::stop_token& stop) {
      virt::StageRequest performance;
      performance.script = performer::default_script(performer::Block::mixed, 60);
      performance.script_name = "mixed";
      performance.rig = rig;
      app::NetworkOptions network;
      network.to = address_;
      network.wait_s = 0;
      network.loop = true;
      network.title = "";
      network.enough = [&stop](std::size_t) { return stop.stop_requested(); };
      performed_ = app::perform_to_network(performance, network);
      over_ = true;
    });
  }

  std::string address_;
  Result<app::NetworkSummary> performed_ =
      fail(ErrorCode::internal, "the performance ended early", "bench start");
  std::atomic<bool> over_ = false;
  std::jthread performing_;
};

/// One start of a session.
struct Start {
  double took_s = 0;
  std::optional<double> peak_memory_mb;  ///< Of a session.
};

/// Starts a session as a process of its own and waits for the first packet that it sends.
Result<Start> start_session(std::vector<std::string> command) {
  asio::io_context io;
  udp::socket face = loopback(io);
  command.insert(command.end(),
                 {"--out", fmt::format("livelink://127.0.0.1:{}", face.local_endpoint().port())});
  std::optional<Clock::time_point> first;
  face.non_blocking(true);
  const auto from = Clock::now();
  std::jthread watching([&](const std::stop_token& stop) {
    std::array<std::byte, 2048> packet{};
    boost::system::error_code code;
    while (!stop.stop_requested() && face.receive(asio::buffer(packet), 0, code) == 0)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    if (!stop.stop_requested()) first = Clock::now();
  });
  const auto said = app::run_child(command);
  watching.request_stop();
  watching.join();
  if (!said) return std::unexpected(said.error());
  if (!said->succeeded() || !first)
    return fail(ErrorCode::internal,
                said->complaints.empty() ? "the session sent no frame" : said->complaints, "bench start");
  const app::Json summary = app::Json::parse(said->out, nullptr, false);
  return Start{to_seconds(*first - from), summary.value("peak_memory_mb", 0.0)};
}

/// Loads the program and nothing else.
Result<Start> load_program(const fs::path& program) {
  const auto from = Clock::now();
  MIEN_TRY(app::run_child({program.string(), "--version"}));
  return Start{seconds_since(from), {}};
}

/// All starts of one kind.
struct StartRow {
  std::string key;   ///< In the JSON object.
  std::string what;  ///< For people.
  std::function<Result<Start>()> start;
  std::vector<double> took_s = {};
  std::optional<double> peak_memory_mb = {};  ///< The most of any.
};

const Columns<StartRow>& start_columns() {
  using Row = StartRow;
  static const Columns<Row> columns = {
      {"", "", "{}", &Row::what},
      {"median_ms", "ms", "{:.1f}", [](const Row& row) { return 1e3 * spread_of(row.took_s).p50_s; }},
      {"worst_ms", "worst", "{:.1f}", [](const Row& row) { return 1e3 * spread_of(row.took_s).worst_s; }},
      {"peak_memory_mb", "MB", "{:.1f}", [](const Row& row) { return or_null(row.peak_memory_mb); }}};
  return columns;
}

Result<void> run_start_bench(const StartBench& options) {
  MIEN_TRY_ASSIGN(const fs::path program, app::find_helper("mien"));
  MIEN_TRY_ASSIGN(const auto performer, Performer::begin());
  MIEN_TRY_ASSIGN(const fs::path headset, find_resource("rigs/headset.toml"));
  const Pictures pictures = made_up_pictures(kPictures);
  MIEN_TRY_ASSIGN(const auto cameras, GoodCameras::open(pictures, kCameras));
  const auto session = [&](const char* page, const std::vector<std::string>& more) {
    std::vector<std::string> command = {program.string(), "live", "--page", page, "--for", "1", "--json"};
    command.insert(command.end(), more.begin(), more.end());
    return start_session(std::move(command));
  };
  const std::vector<std::string> of_boards = {"--listen", performer->address()};
  std::vector<std::string> of_cameras = {"--rig", headset.string()};
  for (std::size_t c = 0; c < kCameras; ++c)
    of_cameras.insert(of_cameras.end(), {"--listen", cameras->address(c)});
  std::vector<StartRow> rows = {
      {"without_page", "mien live with --page off, to its first frame",
       [&] { return session("off", of_boards); }},
      {"with_page", "the same with the page", [&] { return session("127.0.0.1:0", of_boards); }},
      {"with_cameras", "with four cameras instead, and the page",
       [&] { return session("127.0.0.1:0", of_cameras); }},
      {"program_alone", "mien --version, to its end", [&] { return load_program(program); }}};
  const Progress progress = app::terminal_progress("bench start");
  // They take turns. The first of each is not counted: after it the program is in memory.
  for (int round = 0; round <= options.times; ++round) {
    for (StartRow& row : rows) {
      MIEN_TRY_ASSIGN(const Start start, row.start());
      if (round == 0) continue;
      row.took_s.push_back(start.took_s);
      row.peak_memory_mb = std::max(row.peak_memory_mb, start.peak_memory_mb);
    }
    if (!progress(static_cast<double>(round) / options.times, fmt::format("start {}", round)))
      return fail(ErrorCode::cancelled, "stopped", "bench start");
  }
  app::Json measured;
  for (const StartRow& row : rows) measured[row.key] = json_of(row, start_columns());
  measured["program_alone"].erase("peak_memory_mb");
  measured["starts"] = options.times;
  measure::Report report("How long a session takes to start",
                         fmt::format("{} starts of each", options.times));
  report.table(table_of("", rows, start_columns()));
  return put_out(options.to, report, measured);
}

}  // namespace

void add_start_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<StartBench>();
  const app::Command start = commands.add_under(
      bench, "start",
      "How long `mien live` takes from its start to the first frame that it sends, and how much memory, as a "
      "process of its own while a performer performs; the same of a headset, whose four cameras are asked; "
      "beside them what loading the program takes",
      "mien bench start --times 20 --json", [options] { return run_start_bench(*options); });
  start.add_option("--times", options->times, "How often each is started").in_range(1, 1000).show_default();
  app::add_json_flag(start, options->to.json);
}

}  // namespace mien::lab

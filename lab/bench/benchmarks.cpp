#include "lab/bench/benchmarks.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include "app/command.h"
#include "app/live/live_session.h"
#include "app/live/perform_network.h"
#include "app/live/running_session.h"
#include "lab/bench/clock.h"
#include "lab/bench/loopback.h"
#include "lab/commands/output.h"
#include "mien/core/files.h"
#include "mien/live/latency.h"

namespace mien::lab {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

struct BenchOptions {
  double seconds = 20;
  std::string model;
  Output to;
};

/// Wakes who receives there: one byte is the end.
void end_receiving(const udp::endpoint& there) {
  try {
    asio::io_context io;
    const std::byte end{};
    loopback(io).send_to(asio::buffer(&end, 1), there);
  } catch (const boost::system::system_error&) {  // Then it hears nothing more anyway.
  }
}

/// What the network and the scheduler take by themselves: a datagram through loopback to a thread that does
/// nothing but send it on, sixty times a second, as the session's are.
class Relay {
 public:
  Relay()
      : in_(loopback(io_)),
        out_(loopback(io_)),
        in_end_(in_.local_endpoint()),
        out_end_(out_.local_endpoint()) {
    relay_ = std::jthread([this] { relay(); });
    sender_ = std::jthread([this] { send(); });
  }
  ~Relay() { stop(); }

  live::Latencies stop() {
    stopping_ = true;
    end_receiving(out_end_);  // Nothing may be on its way back, when a socket has failed.
    if (sender_.joinable()) sender_.join();
    end_receiving(in_end_);
    if (relay_.joinable()) relay_.join();
    return took_;
  }

 private:
  void relay() {
    std::array<std::byte, 512> bytes{};
    boost::system::error_code failed;
    while (!failed) {
      const std::size_t size = in_.receive(asio::buffer(bytes), 0, failed);
      if (failed || size <= 1) return;
      in_.send_to(asio::buffer(bytes.data(), size), out_end_, 0, failed);
    }
  }
  void send() {
    // A Live Link frame's size.
    std::array<std::byte, 310> bytes{};
    auto next = Clock::now();
    while (!stopping_) {
      next += std::chrono::nanoseconds(16'666'667);
      std::this_thread::sleep_until(next);
      const auto from = Clock::now();
      boost::system::error_code failed;
      out_.send_to(asio::buffer(bytes), in_end_, 0, failed);
      if (!failed && out_.receive(asio::buffer(bytes), 0, failed) <= 1) return;
      if (failed) return;  // The figures say how many there were.
      took_.add(Clock::now() - from);
    }
  }

  asio::io_context io_;
  udp::socket in_, out_;
  udp::endpoint in_end_, out_end_;
  std::atomic<bool> stopping_ = false;
  live::Latencies took_;
  std::jthread relay_, sender_;
};

/// From what to what, and how long that took each time.
struct LatencyRow {
  std::string what;
  live::Latencies took;
};

const Columns<LatencyRow>& latency_columns() {
  using Row = LatencyRow;
  static const Columns<Row> columns = {
      {"", "", "{}", &Row::what},
      {"p50_ms", "p50 ms", "{:.3f}",
       [](const Row& row) { return 1e3 * to_seconds(row.took.percentile(0.5)); }},
      {"p99_ms", "p99 ms", "{:.3f}",
       [](const Row& row) { return 1e3 * to_seconds(row.took.percentile(0.99)); }},
      {"max_ms", "max ms", "{:.3f}", [](const Row& row) { return 1e3 * to_seconds(row.took.largest()); }},
      {"count", "", "", [](const Row& row) { return row.took.count(); }}};
  return columns;
}

/// What is measured of a session: the rows, and the rest of the JSON object.
struct MeasuredLive {
  std::vector<LatencyRow> rows;
  app::Json rest;
};

/// A performance for a session in this process that sends to `receiver`. Errors: the session's and the
/// performance's.
Result<MeasuredLive> measure_live(const BenchOptions& options, const udp::endpoint& receiver) {
  virt::StageRequest performance;
  performance.script = performer::default_script(performer::Block::mixed, options.seconds);
  performance.script_name = "mixed";
  MIEN_TRY_ASSIGN(performance.rig, find_resource("rigs/default.toml"));
  app::LiveRequest request;
  request.model = options.model;
  request.listen = {"udp://127.0.0.1:0"};
  request.out = {fmt::format("livelink://127.0.0.1:{}", receiver.port())};
  request.page = "off";
  MIEN_TRY_ASSIGN(const app::LiveSession session, app::open_live(request));
  app::RunningSession running(*session.engine);
  Relay relay;
  app::NetworkOptions network;
  network.to = session.engine->listening().front();
  const auto performed = app::perform_to_network(performance, network);
  const live::Latencies network_took = relay.stop();
  const auto summary = running.finish();
  if (!performed) return std::unexpected(performed.error());
  if (!summary) return std::unexpected(summary.error());
  const live::Latencies& took = summary->latency;
  return MeasuredLive{
      .rows = {{"last sample in to the sink's packet out", took},
               {"a thread that only sends datagrams on", network_took}},
      .rest = {
          {"vs_network_p50", to_seconds(took.percentile(0.5)) / to_seconds(network_took.percentile(0.5))},
          {"vs_network_p99", to_seconds(took.percentile(0.99)) / to_seconds(network_took.percentile(0.99))},
          {"frames", summary->frames},
          {"missed", summary->missed},
          {"packets", performed->packets},
          {"kernels", summary->kernels},
          {"hash", summary->hash}}};
}

Result<void> run_bench_live(const BenchOptions& options) {
  // Somebody receives the face, and counts.
  asio::io_context io;
  udp::socket receiver = loopback(io);
  std::atomic<std::uint64_t> received = 0;
  std::jthread receiving([&] {
    std::array<std::byte, 2048> bytes{};
    boost::system::error_code failed;
    while (receiver.receive(asio::buffer(bytes), 0, failed) > 1 && !failed) ++received;
  });
  const Result<MeasuredLive> measured = [&]() -> Result<MeasuredLive> {
    try {
      return measure_live(options, receiver.local_endpoint());
    } catch (const std::exception& error) {  // Who receives is to be told, too.
      return fail(ErrorCode::internal, error.what(), "bench live");
    }
  }();
  end_receiving(receiver.local_endpoint());
  receiving.join();
  if (!measured) return std::unexpected(measured.error());
  app::Json json = {{"live", json_of(measured->rows[0], latency_columns())},
                    {"network", json_of(measured->rows[1], latency_columns())}};
  json.update(measured->rest);
  json["received"] = received.load();
  measure::Report report("From the last sample of a frame to the packet that leaves");
  report.table(table_of("", measured->rows, latency_columns()));
  report.text(fmt::format("{} frames, {} missed, {} received; kernels {}, hash {}",
                          json["frames"].get<std::uint64_t>(), json["missed"].get<std::uint64_t>(),
                          received.load(), json["kernels"].get<std::string>(),
                          json["hash"].get<std::string>()));
  return put_out(options.to, report, json);
}

}  // namespace

void add_benchmarks(app::Commands& commands) {
  auto options = std::make_shared<BenchOptions>();
  const app::Command bench = commands.add(
      "bench", "How fast it is on this machine, beside what it is compared with", "mien bench live", nullptr);
  bench.require_commands(0, 1);
  const app::Command live = commands.add_under(
      bench, "live",
      "From the arrival of the last sample of a frame to the packet that leaves, with a virtual performer on "
      "real sockets; beside it what loopback and the scheduler take by themselves",
      "mien bench live --seconds 20 --json", [options] { return run_bench_live(*options); });
  live.add_option("--seconds", options->seconds, "How long the performer performs")
      .number_between(2.0, 3600.0)
      .show_default();
  live.add_option("--model", options->model, "The live model (default: models/live.safetensors)");
  app::add_json_flag(live, options->to.json);
  add_start_bench(commands, bench);
  add_attack_bench(commands, bench);
  add_render_bench(commands, bench);
  add_shaping_bench(commands, bench);
  add_onnxruntime_bench(commands, bench);
  add_causal_bench(commands, bench);
  add_headset_bench(commands, bench);
}

}  // namespace mien::lab

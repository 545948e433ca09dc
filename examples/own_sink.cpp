// How do frames get into a program of one's own? A sink that draws the jaw's opening as a bar:
//   own_sink                          a virtual performer's reading, in it
//   own_sink vmc://127.0.0.1 ...      and in sinks that Mien has (docs/reference/sinks.md)

#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <cstdio>

#include "mien/performer/performer.h"
#include "mien/sink/sink.h"

namespace {
using namespace mien;

/// Sends a bar of the jaw's opening to the terminal, ten times a second. A real one would fill an engine's
/// curves.
class TerminalSink final : public sink::Sink {
 public:
  void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept override {
    if (frame_index % 6 != 0) return;  // Of the 60 Hz grid.
    constexpr std::size_t kJaw = face::shape("jawOpen");
    constexpr char kBar[] = "########################################";
    // A sink must not throw: std::printf, not fmt::print. Neither may it wait: a slow receiver gets fewer
    // frames.
    const int length = static_cast<int>(40 * std::min(frame.weights[kJaw], 1.0F));
    const bool sent =
        std::printf("%6.2f s %.*s\n", to_seconds(frame.time.time_since_epoch()), length, kBar) > 0;
    ++(sent ? sent_ : failed_);
  }
  [[nodiscard]] sink::Status status() const override {
    return {.address = "terminal", .sent = sent_, .failed = failed_};
  }

 private:
  std::uint64_t sent_ = 0, failed_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  // Frames come from a session (see own_device.cpp); here a virtual performer's truth stands in for them.
  Random random(1);
  const face::Motion motion = performer::perform(performer::default_script(performer::Block::reading, 3),
                                                 performer::draw_style(random), random);
  boost::asio::io_context network;
  std::vector<std::unique_ptr<sink::Sink>> sinks;
  sinks.push_back(std::make_unique<TerminalSink>());
  for (int i = 1; i < argc; ++i) {
    auto opened = sink::open_sink(network, argv[i]);
    if (!opened) {
      fmt::print(stderr, "{}\n", opened.error().message());
      return 1;
    }
    sinks.push_back(*std::move(opened));
  }

  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    face::OutputFrame frame;
    frame.time = DeviceTime(frame_offset(static_cast<std::int64_t>(i)));
    frame.weights = motion.frames[i].weights;
    frame.head = motion.frames[i].head;
    for (const auto& sink : sinks) sink->send(frame, static_cast<std::int64_t>(i));
    network.poll();  // Sinks that have sockets work here.
  }
  for (const auto& sink : sinks)
    std::printf("%s: %llu frames sent\n", sink->status().address.c_str(),
                static_cast<unsigned long long>(sink->status().sent));
}

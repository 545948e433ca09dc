#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "app/json_output.h"
#include "lab/bench/clock.h"
#include "lab/commands/output.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/speech/listeners.h"
#include "mien/speech/spoken_mouth.h"
#include "mien/synthetic/speech/spoken_passage.h"

namespace mien::lab {
namespace {

struct SpeechBench {
  std::string sound, model;
  Output to;
};

struct HeardIn {
  std::string way;
  double p50_ms = 0, p99_ms = 0, largest_ms = 0;
  double core = 0;     ///< Share of a core that real time takes.
  double shown_s = 0;  ///< What its newest answer is of, before the block's end.
};

const Columns<HeardIn>& heard_columns() {
  static const Columns<HeardIn> columns = {{"", "", "{}", &HeardIn::way},
                                           {"p50_ms", "p50 ms", "{:.3f}", &HeardIn::p50_ms},
                                           {"p99_ms", "p99 ms", "{:.3f}", &HeardIn::p99_ms},
                                           {"max_ms", "max ms", "{:.3f}", &HeardIn::largest_ms},
                                           {"share_of_a_core", "core, %", "{:.2f}", &HeardIn::core, 100},
                                           {"answer_is_older_ms", "answer is older, ms", "{:.0f}",
                                            [](const HeardIn& row) { return 1e3 * row.shown_s; }}};
  return columns;
}

/// From a block to the frame that shows it, block by block.
HeardIn measure_listener(const std::string& way, speech::Listener& listener,
                         const std::vector<speech::Block>& blocks) {
  speech::SpokenMouth mouth(listener.smoothing());
  HeardIn took{.way = way};
  std::vector<double> each;
  double sum = 0;
  DeviceTime time{};
  for (const speech::Block& block : blocks) {
    const auto from = Clock::now();
    const speech::Heard heard = listener.push(time, block);
    mouth.push(heard);
    [[maybe_unused]] const auto shown = mouth.tick(heard.time);
    each.push_back(seconds_since(from));
    sum += each.back();
    time += speech::kBlockDuration;
    took.shown_s = to_seconds(time - heard.time);
  }
  std::ranges::sort(each);
  took.p50_ms = 1e3 * each[each.size() / 2];
  took.p99_ms = 1e3 * each[std::min(each.size() - 1, each.size() * 99 / 100)];
  took.largest_ms = 1e3 * each.back();
  took.core = sum / (to_seconds(speech::kBlockDuration) * static_cast<double>(blocks.size()));
  return took;
}

Result<void> run_speech_bench(const SpeechBench& options) {
  MIEN_TRY_ASSIGN(const auto bytes, read_file(options.sound));
  MIEN_TRY_ASSIGN(const Sound sound, parse_wav(bytes, options.sound));
  MIEN_TRY_ASSIGN(const std::vector<float> samples, synthetic::resampled(sound));
  const std::vector<speech::Block> blocks = synthetic::blocks_of(samples);
  if (blocks.empty()) return fail(ErrorCode::truncated, "there is no sound in it", options.sound);
  MIEN_TRY_ASSIGN(const std::filesystem::path model,
                  app::path_or(options.model, "models/speech.safetensors"));
  MIEN_TRY_ASSIGN(speech::SpeechNetworkFile file, speech::read_speech_network(model));
  MIEN_TRY_ASSIGN(speech::SpeechNetwork network, speech::SpeechNetwork::create(std::move(file)));
  MIEN_TRY_ASSIGN(speech::PhoneDecoder decoder, speech::PhoneDecoder::create());
  speech::LearnedListener learned(std::move(network));
  speech::PhoneListener phones(std::move(decoder));
  // Each once before it counts: memory and caches.
  for (speech::Listener* listener :
       {static_cast<speech::Listener*>(&learned), static_cast<speech::Listener*>(&phones)}) {
    measure_listener("", *listener, blocks);
    listener->reset();
  }
  const std::vector<HeardIn> rows = {measure_listener("network", learned, blocks),
                                     measure_listener("phones", phones, blocks)};
  app::Json json = {{"sound", options.sound}, {"blocks", blocks.size()}};
  for (const HeardIn& row : rows) json[row.way] = json_of(row, heard_columns());
  json["phones_over_network"] = rows[1].core / rows[0].core;
  measure::Report report("From sound to the mouth", fmt::format("{} blocks of 20 ms", blocks.size()));
  report.table(table_of("", rows, heard_columns()));
  report.text(
      fmt::format("Phones take {:.1f} times as much of a core as the network.", rows[1].core / rows[0].core));
  return put_out(options.to, report, json);
}

}  // namespace

void add_speech_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<SpeechBench>();
  const app::Command command = commands.add_under(
      bench, "speech", "Both ways from sound to the mouth, a block of 20 ms at a time: how long each takes",
      "mien bench speech talk.wav", [options] { return run_speech_bench(*options); });
  command.add_option("sound", options->sound, "A WAV file of speech").required();
  command.add_option("--model", options->model, "The network (default: models/speech.safetensors)");
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab

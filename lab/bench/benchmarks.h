#pragma once

#include "app/command.h"

namespace mien::lab {

/// `bench` and its commands.
void add_benchmarks(app::Commands& commands);

/// Each adds its command beneath `bench`.
void add_attack_bench(app::Commands& commands, app::Command bench);
void add_causal_bench(app::Commands& commands, app::Command bench);
void add_headset_bench(app::Commands& commands, app::Command bench);
void add_onnxruntime_bench(app::Commands& commands, app::Command bench);
void add_render_bench(app::Commands& commands, app::Command bench);
void add_shaping_bench(app::Commands& commands, app::Command bench);
void add_start_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab

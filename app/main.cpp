#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "app/command.h"
#include "app/usage_error.h"

int main(int argc, char** argv) {
  using namespace mien;
  CLI::App program("Mien: facial performance capture without a camera looking at the face", "mien");
  program.set_version_flag("--version", "mien " MIEN_VERSION);
  program.require_subcommand(0, 1);
  app::Commands commands(program);
  app::add_demo_command(commands);
  app::add_live_command(commands);
  app::add_calibrate_command(commands);
  app::add_perform_command(commands);
  app::add_record_command(commands);
  app::add_personalise_command(commands);
  app::add_train_command(commands);
  app::add_solve_command(commands);
  app::add_evaluate_command(commands);
  app::add_export_command(commands);
  app::add_import_command(commands);
  app::add_study_command(commands);
  app::add_render_command(commands);
  app::add_face_command(commands);
  app::add_take_command(commands);
  app::add_bench_command(commands);

  try {
    program.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return program.exit(help);
  } catch (const CLI::CallForAllHelp& help) {
    return program.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return program.exit(version);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "mien: {}\n", app::usage_error(program, error));
    return 2;
  }

  try {
    if (const auto done = commands.run(); !done) {
      app::clear_progress();
      fmt::print(stderr, "mien: {}\n", done.error().message());
      return is_bad_input(done.error().code) ? 2 : 1;
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "mien: {}; this is a defect, please report it\n", error.what());
    return 1;
  }
  return 0;
}

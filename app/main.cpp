#include "app/command.h"
#include "app/usage_error.h"

int main(int argc, char** argv) {
  using namespace mien;
  app::Commands commands("mien", "Mien: facial performance capture without a camera looking at the face");
  commands.require_one(false);
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
  return commands.main(argc, argv, app::usage_error);
}

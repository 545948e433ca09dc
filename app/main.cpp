#include "app/command.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
  using namespace mien;
#ifdef __GLIBC__
  // Faces and pictures are made one after another: their memory is kept for the next instead of given back to
  // the system, which takes as long to hand out a face's pages as a face takes to make.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
  app::Commands commands("mien", "Mien: facial performance capture without a camera looking at the face");
  commands.require_one(false);
  commands.heading("Capture");
  app::add_demo_command(commands);
  app::add_live_command(commands);
  app::add_calibrate_command(commands);
  app::add_record_command(commands);
  app::add_perform_command(commands);
  commands.heading("Takes and faces");
  app::add_take_command(commands);
  app::add_import_command(commands);
  app::add_solve_command(commands);
  app::add_export_command(commands);
  app::add_render_command(commands);
  app::add_face_command(commands);
  commands.heading("Learn");
  app::add_dataset_command(commands);
  app::add_align_command(commands);
  app::add_personalise_command(commands);
  app::add_train_command(commands);
  commands.heading("Judge");
  app::add_evaluate_command(commands);
  app::add_study_command(commands);
  app::add_bench_command(commands);
  return commands.main(argc, argv, app::usage_error);
}

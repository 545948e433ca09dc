#include "lab/commands/output.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/command.h"
#include "mien/core/files.h"

namespace mien::lab {
namespace {

void print(const Output& to, const std::string& page, const measure::Report& report, const Json& json,
           const std::string& notes) {
  app::clear_progress();
  if (to.json)
    app::print_json(json);
  else
    fmt::print("{}{}{}", report.plain_text(), notes, page.empty() ? "" : fmt::format("report: {}\n", page));
}

}  // namespace

Result<void> check_page(const Output& to) {
  if (to.out.empty()) return {};
  return app::check_output(to.out, {".html"});
}

Result<void> put_out(const Output& to, const measure::Report& report, const Json& json,
                     const std::string& notes) {
  if (!to.out.empty()) MIEN_TRY(report.write(to.out));
  print(to, to.out, report, json, notes);
  return {};
}

Result<void> put_out_in_folder(const Output& to, std::string_view name, const measure::Report& report,
                               const Json& json, const std::string& notes) {
  const std::filesystem::path stem = std::filesystem::path(to.out) / name;
  MIEN_TRY(write_file(stem.string() + ".txt", report.plain_text()));
  MIEN_TRY(write_file(stem.string() + ".json", app::json_text(json)));
  MIEN_TRY(report.write(stem.string() + ".html"));
  print(to, stem.string() + ".html", report, json, notes);
  return {};
}

}  // namespace mien::lab

#pragma once

#include <string>
#include <string_view>

#include "app/json_output.h"
#include "lab/columns.h"
#include "mien/core/error.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// Where the result of a study or benchmark goes.
struct Output {
  std::string out;    ///< An HTML file, or a folder; empty: neither.
  bool json = false;  ///< stdout is the JSON object, not text.
};

/// Before long work: whether `to.out` may be written as a page. Errors: app::check_output's.
[[nodiscard]] Result<void> check_page(const Output& to);

/// Writes the page to `to.out`, where one is named, and prints the report as text or the object as JSON.
/// `notes`: lines that follow the text. Errors: the page's.
[[nodiscard]] Result<void> put_out(const Output& to, const measure::Report& report, const Json& json,
                                   const std::string& notes = {});

/// The same with `to.out` as a folder that is there: the report as NAME.html and NAME.txt, the object as
/// NAME.json.
[[nodiscard]] Result<void> put_out_in_folder(const Output& to, std::string_view name,
                                             const measure::Report& report, const Json& json,
                                             const std::string& notes = {});

}  // namespace mien::lab

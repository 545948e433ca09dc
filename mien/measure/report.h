#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/measure/plot.h"

namespace mien::measure {

/// Makes a page's line plots zoomable where scripts run (zoom.js): draws a stretch anew from the numbers that
/// svg(LinePlot) puts into a drawing's attributes, by the rules by which that draws the whole, which it
/// leaves alone. It fetches and stores nothing; what it shows of names is text, never markup. Plain
/// JavaScript of 2022.
extern const std::string_view kZoomScript;

/// Rows under column heads. Cells are plain text; columns whose cells are all numbers stand to the right. A
/// row of one cell is a head of its own, across all columns.
struct Table {
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> strong_rows;  ///< Rows that the reader should see first.
};

/// The same for a terminal: columns as wide as their widest cell, numbers to the right; a strong row of one
/// cell has an empty line before it. Columns that do not fit into 110 characters follow below, beside the
/// first column again.
[[nodiscard]] std::string plain_text(const Table& table);

/// One number that matters, shown large.
struct KeyFigure {
  std::string name;
  std::string value;  ///< With its unit.
  std::string note;   ///< What it is measured against; may be empty.
};

/// A report that is one HTML file: styles, drawings, pictures and films are inside, nothing is fetched. A
/// page with line plots has the one script that zooms them (kZoomScript), without which it is as complete.
/// Light or dark as the reader's system is. Parts appear in the order in which they are added. All text is
/// plain UTF-8.
class Report {
 public:
  explicit Report(std::string title, std::string subtitle = {});

  void heading(const std::string& words);
  void text(const std::string& paragraph);
  void key_figures(const std::vector<KeyFigure>& figures);
  void table(const Table& table);
  void plot(const LinePlot& plot);
  void bars(const BarPlot& plot);
  /// `png`: a PNG file's content.
  void image(std::span<const std::byte> png, const std::string& caption);
  /// `mp4`: an MP4 file's content; some megabytes at most, since it stands inside the page.
  void film(std::span<const std::byte> mp4, const std::string& caption);

  /// The whole page.
  [[nodiscard]] std::string html() const;
  /// The same for a terminal, without plots, pictures and films: lines of at most 110 characters where words
  /// allow it.
  [[nodiscard]] std::string plain_text() const;
  /// Writes it, whole or not at all. Errors: io.
  [[nodiscard]] Result<void> write(const std::filesystem::path& path) const;

 private:
  void figure(const std::string& title, const std::vector<std::string>& series, const std::string& drawing);

  std::string title_;
  std::string subtitle_;
  std::string body_;  // As HTML.
  std::string text_;  // As plain text.
  bool has_line_plot_ = false;
};

}  // namespace mien::measure

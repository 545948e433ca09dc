#include "mien/measure/report.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "mien/core/encoding.h"
#include "mien/core/files.h"

namespace mien::measure {

/// report.css. Series colours keep their hue in both modes and differ in lightness too, for the colour-blind.
extern const std::string_view kReportStyle;

namespace {

/// How many characters, not bytes, of UTF-8.
std::size_t width_of(const std::string& words) {
  return static_cast<std::size_t>(
      std::ranges::count_if(words, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Of a line of plain text.
constexpr std::size_t kTextWidth = 110;

/// A paragraph in lines of plain text, which break between words.
std::string wrapped(const std::string& paragraph) {
  std::string out, line;
  for (std::size_t begin = 0; begin < paragraph.size();) {
    const std::size_t end = std::min(paragraph.find(' ', begin), paragraph.size());
    const std::string word = paragraph.substr(begin, end - begin);
    begin = end + 1;
    if (!line.empty() && width_of(line) + 1 + width_of(word) > kTextWidth) {
      out += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return out + line + "\n";
}

/// Cells of more characters need room beside numbers, however narrow the page is.
constexpr std::size_t kWidthOfSentences = 40;

bool is_number(const std::string& cell) {
  if (cell.empty() || cell == "-" || cell == "–") return true;
  char* end = nullptr;
  std::strtod(cell.c_str(), &end);
  // A unit or a spread may follow: "0.75 mm", "0.75 ± 0.30", "12 %".
  return end != cell.c_str() && (*end == 0 || *end == ' ');
}

/// Columns whose cells are all numbers.
std::vector<bool> number_columns(const Table& table) {
  std::vector<bool> numbers(table.columns.size(), !table.rows.empty());
  for (const auto& row : table.rows)
    for (std::size_t c = 0; row.size() > 1 && c < numbers.size() && c < row.size(); ++c)
      numbers[c] = numbers[c] && is_number(row[c]);
  return numbers;
}

}  // namespace

std::string plain_text(const Table& table) {
  const std::vector<bool> numbers = number_columns(table);
  std::vector<std::size_t> widths;
  for (const std::string& column : table.columns) widths.push_back(width_of(column));
  for (const auto& row : table.rows)
    for (std::size_t c = 0; row.size() > 1 && c < widths.size() && c < row.size(); ++c)
      widths[c] = std::max(widths[c], width_of(row[c]));
  std::string out = table.caption.empty() ? "" : wrapped(table.caption) + "\n";
  for (std::size_t begin = 1, end = 1; begin == 1 || begin < widths.size(); begin = end) {
    for (std::size_t width = widths.empty() ? 0 : widths[0];
         end < widths.size() && (end == begin || width + 2 + widths[end] <= kTextWidth); ++end)
      width += 2 + widths[end];
    if (begin > 1) out += "\n";
    const auto line = [&](const std::vector<std::string>& cells) {
      std::string words;
      for (std::size_t c = 0; c < std::min({end, cells.size(), widths.size()}); c = c == 0 ? begin : c + 1) {
        const std::string blanks(widths[c] - std::min(widths[c], width_of(cells[c])), ' ');
        words += (c > 0 ? "  " : "") + (numbers[c] ? blanks + cells[c] : cells[c] + blanks);
      }
      words.erase(words.find_last_not_of(' ') + 1);
      out += width_of(words) > kTextWidth ? wrapped(words) : words + "\n";
    };
    line(table.columns);
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const bool heads = table.rows[r].size() == 1 && table.columns.size() > 1;
      if (heads && std::ranges::find(table.strong_rows, r) != table.strong_rows.end()) out += "\n";
      line(table.rows[r]);
    }
    if (end == begin) break;  // A table of one column.
  }
  return out;
}

Report::Report(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void Report::heading(const std::string& words) {
  body_ += "<h2>" + escaped(words) + "</h2>\n";
  text_ += "\n" + words + "\n" + std::string(width_of(words), '-') + "\n\n";
}

void Report::text(const std::string& paragraph) {
  body_ += "<p>" + escaped(paragraph) + "</p>\n";
  text_ += wrapped(paragraph) + "\n";
}

void Report::key_figures(const std::vector<KeyFigure>& figures) {
  body_ += "<div class=\"keys\">\n";
  for (const KeyFigure& f : figures) {
    body_ += "<div class=\"key\"><span>" + escaped(f.name) + "</span><b>" + escaped(f.value) + "</b>";
    if (!f.note.empty()) body_ += "<span>" + escaped(f.note) + "</span>";
    body_ += "</div>\n";
    text_ += wrapped(f.name + ": " + f.value + (f.note.empty() ? "" : " (" + f.note + ")"));
  }
  body_ += "</div>\n";
  text_ += "\n";
}

void Report::table(const Table& table) {
  const std::vector<bool> numbers = number_columns(table);
  const auto cell = [&](const char* kind, std::size_t c, const std::string& words) {
    const char* style = c < numbers.size() && numbers[c]      ? " class=\"number\">"
                        : width_of(words) > kWidthOfSentences ? " class=\"words\">"
                                                              : ">";
    return std::string("<") + kind + style + escaped(words) + "</" + kind + ">";
  };
  body_ += "<figure>";
  if (!table.caption.empty()) body_ += "<figcaption>" + escaped(table.caption) + "</figcaption>";
  body_ += "<div class=\"scroll\"><table><thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) body_ += cell("th", c, table.columns[c]);
  body_ += "</tr></thead><tbody>\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    body_ +=
        std::ranges::find(table.strong_rows, r) != table.strong_rows.end() ? "<tr class=\"strong\">" : "<tr>";
    if (table.rows[r].size() == 1 && table.columns.size() > 1)
      body_ += "<td colspan=\"" + std::to_string(table.columns.size()) + "\">" + escaped(table.rows[r][0]) +
               "</td>";
    else
      for (std::size_t c = 0; c < table.rows[r].size(); ++c) body_ += cell("td", c, table.rows[r][c]);
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div></figure>\n";
  text_ += measure::plain_text(table) + "\n";
}

void Report::figure(const std::string& title, const std::vector<std::string>& series,
                    const std::string& drawing) {
  body_ += "<figure><figcaption>" + escaped(title) + "</figcaption>\n";
  if (series.size() > 1) {
    body_ += "<div class=\"legend\">";
    for (std::size_t i = 0; i < series.size(); ++i)
      body_ += "<span><i style=\"background:var(--series-" + std::to_string(i % kSeriesColours + 1) +
               ")\"></i>" + escaped(series[i]) + "</span>";
    body_ += "</div>\n";
  }
  body_ += drawing + "</figure>\n";
}

void Report::plot(const LinePlot& plot) {
  std::vector<std::string> names;
  for (const Line& line : plot.lines) names.push_back(line.name);
  figure(plot.title, names, svg(plot));
  has_line_plot_ = true;
}

void Report::bars(const BarPlot& plot) {
  figure(plot.title, plot.series, svg(plot));
}

void Report::image(std::span<const std::byte> png, const std::string& caption) {
  body_ += "<figure class=\"picture\"><img alt=\"" + escaped(caption) + "\" src=\"data:image/png;base64," +
           base64(png) + "\"><figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

void Report::film(std::span<const std::byte> mp4, const std::string& caption) {
  body_ += "<figure class=\"picture\"><video controls loop muted playsinline src=\"data:video/mp4;base64," +
           base64(mp4) + "\"></video><figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

std::string Report::html() const {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>";
  page += escaped(title_) + "</title>\n<style>\n" + std::string(kReportStyle) +
          "</style>\n</head>\n<body>\n<main>\n<h1>" + escaped(title_) + "</h1>\n";
  if (!subtitle_.empty()) page += "<p class=\"subtitle\">" + escaped(subtitle_) + "</p>\n";
  page += body_ + "</main>\n";
  if (has_line_plot_) page += "<script>\n" + std::string(kZoomScript) + "</script>\n";
  return page + "</body>\n</html>\n";
}

std::string Report::plain_text() const {
  return wrapped(title_ + (subtitle_.empty() ? "" : ": " + subtitle_)) + "\n" + text_;
}

Result<void> Report::write(const std::filesystem::path& path) const {
  return write_file(path, html());
}

}  // namespace mien::measure

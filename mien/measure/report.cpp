#include "mien/measure/report.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "mien/core/base64.h"
#include "mien/core/files.h"
#include "mien/measure/zoom_script.h"

namespace mien::measure {
namespace {

// Series colours keep their hue in both modes and differ in lightness too, for the colour-blind.
constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --page: #fbfbfa; --card: #ffffff; --ink: #1d2127; --soft: #626b78; --grid: #e4e6ea;
  --line: #dcdfe4; --accent: #2467c4; --series-1: #2467c4; --series-2: #d9622b; --series-3: #1c9467; --series-4: #8a4fbf;
  --series-5: #b98900; --series-6: #6b7684; --series-7: #c23f7d; --series-8: #2f93a8; --series-9: #8a6a48; }
@media (prefers-color-scheme: dark) { :root { --page: #14161a; --card: #1b1e24; --ink: #e7e9ed; --soft: #9aa3b0;
  --grid: #2d323b; --line: #2d323b; --accent: #6ea8ff; --series-1: #6ea8ff; --series-2: #f0925f; --series-3: #4fc795;
  --series-4: #bd93ec; --series-5: #e3bc4c; --series-6: #9aa5b4; --series-7: #f083b4; --series-8: #79cfe0;
  --series-9: #c9a684; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", Roboto, "DejaVu Sans",
  sans-serif; }
main { max-width: 980px; margin: 0 auto; padding: 48px 24px 80px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0; letter-spacing: -0.01em; }
.subtitle { color: var(--soft); margin: 8px 0 0; }
h2 { font-size: 20px; margin: 44px 0 4px; padding-top: 18px; border-top: 1px solid var(--line); }
p { margin: 12px 0; max-width: 70ch; }
figure { position: relative; margin: 20px 0; padding: 16px 18px 12px; background: var(--card);
  border: 1px solid var(--line); border-radius: 10px; }
figcaption { font-weight: 600; margin-bottom: 6px; }
figure.picture figcaption { font-weight: 400; color: var(--soft); margin: 8px 0 0; font-size: 14px; }
figure img, figure video { display: block; width: 100%; height: auto; border-radius: 6px; }
svg { display: block; width: 100%; height: auto; font-size: 12px; fill: var(--soft); }
svg .grid { stroke: var(--grid); stroke-width: 1; }
svg .line { fill: none; stroke-width: 1.8; stroke-linejoin: round; stroke-linecap: round; }
svg .band { fill: var(--accent); opacity: 0.16; }
svg .cursor { stroke: var(--soft); stroke-dasharray: 2 3; }
svg:focus { outline: none; }
svg:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; border-radius: 4px; }
.hint { display: flex; justify-content: space-between; align-items: center; min-height: 24px; max-width: none;
  margin: 6px 0 0; font-size: 12px; color: var(--soft); }
.hint button { font: inherit; padding: 1px 10px; color: var(--accent); background: none; border: 1px solid var(--line);
  border-radius: 6px; cursor: pointer; }
.readout { position: absolute; z-index: 1; pointer-events: none; width: max-content; max-width: 46%; padding: 6px 10px;
  transform: translateX(14px); font-size: 12px; font-variant-numeric: tabular-nums; white-space: pre-wrap;
  background: var(--card); border: 1px solid var(--line); border-radius: 6px; }
.readout.before { transform: translateX(calc(-100% - 14px)); }
.readout span { display: block; }
.readout i { display: inline-block; width: 9px; height: 9px; border-radius: 2px; margin-right: 6px; }
svg .spread { fill: none; stroke: var(--ink); stroke-width: 1.4; stroke-linecap: round; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 13px; color: var(--soft); margin: 0 0 8px; }
.legend i { display: inline-block; width: 11px; height: 11px; border-radius: 3px; margin-right: 7px; }
.keys { display: grid; grid-template-columns: repeat(auto-fit, minmax(170px, 1fr)); gap: 12px; margin: 22px 0; }
.key { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 14px 16px; }
.key span { display: block; color: var(--soft); font-size: 13px; }
.key b { display: block; font-size: 25px; font-weight: 600; line-height: 1.35; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 6px 14px 6px 0; border-bottom: 1px solid var(--grid); vertical-align: top; }
th { color: var(--soft); font-weight: 500; }
tr:last-child td { border-bottom: 0; }
.number { text-align: right; }
td.number { white-space: nowrap; }
.words { min-width: 26ch; }
tr.strong td { font-weight: 650; }
@media print { figure, .key { break-inside: avoid; } .hint, .readout, svg .cursor { display: none !important; } }
)";

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
  page += escaped(title_) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n<h1>" +
          escaped(title_) + "</h1>\n";
  if (!subtitle_.empty()) page += "<p class=\"subtitle\">" + escaped(subtitle_) + "</p>\n";
  page += body_ + "</main>\n";
  if (has_line_plot_) page += "<script>" + std::string(kZoomScript) + "</script>\n";
  return page + "</body>\n</html>\n";
}

std::string Report::plain_text() const {
  return wrapped(title_ + (subtitle_.empty() ? "" : ": " + subtitle_)) + "\n" + text_;
}

Result<void> Report::write(const std::filesystem::path& path) const {
  return write_file(path, html());
}

}  // namespace mien::measure
